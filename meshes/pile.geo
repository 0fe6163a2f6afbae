// Blocks above each other in space, each smaller than the one below, turned about the vertical and shifted; the lowest
// one stands over the plane y = 0. Hexahedra that do not match.
DefineConstant[
  blocks = 3,
  n = 3,       // cells along a side of the lowest block; one less on every second one
  gap = 0.05,  // between the blocks and under the lowest one
  tilt = 0,    // degrees: of the highest block, about z
  skin = 0     // 1: all surfaces of all blocks under the one name skin beside their own names
];
low = gap;
all[] = {};
For b In {0 : blocks - 1}
  f = 100 * b;
  half = 0.5 - 0.08 * b;
  height = 0.5 - 0.05 * b;
  m = n - (b % 2);
  turn = 25 * b * Pi / 180;
  lean = (b == blocks - 1) ? tilt * Pi / 180 : 0;
  sx[] = {-1, 1, 1, -1};
  sz[] = {-1, -1, 1, 1};
  For k In {0 : 1}
    For i In {0 : 3}
      x = half * (Cos(turn) * sx[i] - Sin(turn) * sz[i]);
      z = half * (Sin(turn) * sx[i] + Cos(turn) * sz[i]);
      y = k * height;
      Point(f + 4 * k + i + 1) = {0.03 * b + Cos(lean) * x - Sin(lean) * y,
                                  low + Sin(lean) * x + Cos(lean) * y + half * Fabs(Sin(lean)), 0.02 * b + z};
    EndFor
    For i In {1 : 4}
      Line(f + 4 * k + i) = {f + 4 * k + i, f + 4 * k + 1 + (i % 4)};
    EndFor
    Curve Loop(f + k + 1) = {f + 4 * k + 1 : f + 4 * k + 4};
    Plane Surface(f + k + 1) = {f + k + 1};
  EndFor
  Transfinite Curve {f + 1 : f + 8} = m + 1;
  For i In {1 : 4}
    Line(f + 8 + i) = {f + i, f + 4 + i};
    Transfinite Curve {f + 8 + i} = m;
  EndFor
  For i In {1 : 4}
    Curve Loop(f + 2 + i) = {f + i, f + 9 + (i % 4), -(f + 4 + i), -(f + 8 + i)};
    Plane Surface(f + 2 + i) = {f + 2 + i};
  EndFor
  Surface Loop(f + 1) = {f + 1 : f + 6};
  Volume(f + 1) = {f + 1};
  Physical Volume(Sprintf("block%g", b)) = {f + 1};
  Physical Surface(Sprintf("bottom%g", b)) = {f + 1};
  Physical Surface(Sprintf("top%g", b)) = {f + 2};
  all[] += {f + 1 : f + 6};
  low += height + gap;
EndFor
If (skin == 1)
  Physical Surface("skin") = {all[]};
EndIf
Transfinite Surface "*";
Recombine Surface "*";
Transfinite Volume "*";
