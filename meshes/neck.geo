// A quarter of a round bar, x = R, y = Z: the axis at x = 0, the plane of symmetry at y = 0, where the bar is a little thinner.
DefineConstant[
  radius = 6.413, length = 26.667,
  flaw = 0.018,     // by so much the radius is smaller at y = 0
  nr = 10, nz = 36, // cells across and along
  grading = 0.92,   // of the cells along, towards y = 0
  simplices = 0     // 1: triangles
];
Point(1) = {0, 0, 0}; Point(2) = {(1 - flaw) * radius, 0, 0}; Point(3) = {radius, length, 0}; Point(4) = {0, length, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = nr + 1;
Transfinite Curve {2} = nz + 1 Using Progression 1 / grading;
Transfinite Curve {4} = nz + 1 Using Progression grading;
Transfinite Surface {1} Alternated;
If (simplices == 0)
  Recombine Surface {1};
EndIf
Physical Surface("bar") = {1};
Physical Curve("middle") = {1}; Physical Curve("skin") = {2}; Physical Curve("grip") = {3}; Physical Curve("axis") = {4};
