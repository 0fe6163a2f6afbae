// Cook's membrane: a tapered panel, n x n quadrilaterals, clamped on the left, sheared on the right.
DefineConstant[
  n = 8,
  simplices = 0, // 1: triangles, tetrahedra
  depth = 0      // of a slab with one layer of cells
];
Point(1) = {0, 0, 0};
Point(2) = {48, 44, 0};
Point(3) = {48, 60, 0};
Point(4) = {0, 44, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 2, 3, 4} = n + 1;
Transfinite Surface {1};
If (simplices == 0)
  Recombine Surface {1};
EndIf
If (depth == 0)
  Physical Surface("solid") = {1};
  Physical Curve("left") = {4};
  Physical Curve("right") = {2};
  Physical Curve("bottom") = {1};
  Physical Curve("top") = {3};
Else
  If (simplices == 0)
    slab[] = Extrude {0, 0, depth} { Surface{1}; Layers{1}; Recombine; };
  Else
    slab[] = Extrude {0, 0, depth} { Surface{1}; Layers{1}; };
  EndIf
  Physical Volume("solid") = {slab[1]};
  Physical Surface("faces") = {1, slab[0]};
  Physical Surface("left") = {slab[5]};
  Physical Surface("right") = {slab[3]};
  Physical Surface("bottom") = {slab[2]};
  Physical Surface("top") = {slab[4]};
EndIf
Physical Point("tip") = {3};
