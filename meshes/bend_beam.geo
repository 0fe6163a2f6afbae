// A beam on two supports with a notch from below at its middle, [-span/2, span/2] x [0, height]: one column of cells
// continues the notch. The part that may break, "beam", is a strip beside that column; the rest is "frame".
DefineConstant[
  span = 80, height = 20, notch = 6,
  strip = 2.4,          // half of the width that may break
  cap = 2,              // below the load, that may not
  h = 0.2,              // of cells on the crack's way, and width of the notch
  coarse = 20           // cells at the supports are so much longer
];
x[] = {-span / 2, -strip, -h / 2, h / 2, strip, span / 2};
y[] = {0, notch, height - cap, height};
For j In {0 : 3}
  For i In {0 : 5}
    Point(10 * j + i + 1) = {x[i], y[j], 0};
  EndFor
  For i In {0 : 4}
    Line(100 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 2};
  EndFor
EndFor
For j In {0 : 2}
  For i In {0 : 5}
    Line(200 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 11};
    Transfinite Curve {200 + 10 * j + i} = Round((y[j + 1] - y[j]) / h) + 1;
  EndFor
EndFor
Transfinite Curve {202, 203, 201, 204, 200, 205} = Round(notch / h / 3) + 1 Using Progression 0.92;
far = span / 2 - strip;
growth = 1 + h * (coarse - 1) / far;
cells = Ceil(Log(coarse) / Log(growth));
For j In {0 : 3}
  Transfinite Curve {100 + 10 * j} = cells + 1 Using Progression 1 / growth;
  Transfinite Curve {104 + 10 * j} = cells + 1 Using Progression growth;
  Transfinite Curve {101 + 10 * j, 103 + 10 * j} = Round((strip - h / 2) / h) + 1;
  Transfinite Curve {102 + 10 * j} = 2;
EndFor
For j In {0 : 2}
  For i In {0 : 4}
    If (i != 2 || j > 0)
      n = 10 * j + i;
      Curve Loop(1 + n) = {100 + n, 201 + n, -(110 + n), -(200 + n)};
      Plane Surface(1 + n) = {1 + n};
      Transfinite Surface {1 + n}; Recombine Surface {1 + n};
    EndIf
  EndFor
EndFor
Physical Surface("beam") = {2, 4, 12, 13, 14};
Physical Surface("frame") = {1, 5, 11, 15, 21, 22, 23, 24, 25};
Physical Point("left") = {1};
Physical Point("right") = {6};
Physical Curve("load") = {132};
