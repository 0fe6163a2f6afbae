// Half the section of a round bar, x = R, y = Z: the axis at x = 0, the end that hits at y = 0.
DefineConstant[
  radius = 3.2, length = 32.4,
  nr = 5, nz = 50, // cells across and along
  simplices = 0    // 1: triangles
];
Point(1) = {0, 0, 0}; Point(2) = {radius, 0, 0}; Point(3) = {radius, length, 0}; Point(4) = {0, length, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = nr + 1; Transfinite Curve {2, 4} = nz + 1;
Transfinite Surface {1} Alternated;
If (simplices == 0)
  Recombine Surface {1};
EndIf
Physical Surface("bar") = {1};
Physical Curve("foot") = {1}; Physical Curve("skin") = {2}; Physical Curve("tail") = {3}; Physical Curve("axis") = {4};
Physical Point("edge") = {2};
