// Half the section of a blunt projectile above a round plate, x = R, y = Z. Cells are small where the plug is sheared out.
DefineConstant[
  radius = 10, length = 80,  // of the projectile
  thickness = 12, plate = 250, // of the plate: thickness and radius
  gap = 0.01,
  n = 16,     // cells through the plate
  inner = 7, outer = 13 // radii between which cells are square
];
h = thickness / n;
Point(1) = {0, 0, 0}; Point(2) = {inner, 0, 0}; Point(3) = {outer, 0, 0}; Point(4) = {40, 0, 0}; Point(5) = {plate, 0, 0};
Point(6) = {0, thickness, 0}; Point(7) = {inner, thickness, 0}; Point(8) = {outer, thickness, 0}; Point(9) = {40, thickness, 0};
Point(10) = {plate, thickness, 0};
For k In {1:4}
  Line(k) = {k, k + 1};
  Line(10 + k) = {5 + k, 6 + k};
EndFor
For k In {1:5}
  Line(20 + k) = {k, 5 + k};
  Transfinite Curve {20 + k} = n + 1;
EndFor
Transfinite Curve {1, 11} = Ceil(inner / (1.4 * h)) + 1;
Transfinite Curve {2, 12} = Ceil((outer - inner) / h) + 1;
Transfinite Curve {3, 13} = Ceil(1.2 * n) + 1 Using Progression 1 + 0.75 / n;
Transfinite Curve {4, 14} = 2 * n + 1 Using Progression 1 + 1 / n;
For k In {1:4}
  Curve Loop(k) = {k, 21 + k, -(10 + k), -(20 + k)};
  Plane Surface(k) = {k};
  Transfinite Surface {k}; Recombine Surface {k};
EndFor

z = thickness + gap;
Point(21) = {0, z, 0}; Point(22) = {radius, z, 0}; Point(23) = {radius, z + length, 0}; Point(24) = {0, z + length, 0};
Line(31) = {21, 22}; Line(32) = {22, 23}; Line(33) = {24, 23}; Line(34) = {21, 24};
Transfinite Curve {31, 33} = Ceil(radius / (1.4 * h)) + 1;
Transfinite Curve {32, 34} = 2 * n + 1 Using Progression 1 + 1 / n;
Curve Loop(9) = {31, 32, -33, -34};
Plane Surface(9) = {9};
Transfinite Surface {9}; Recombine Surface {9};

Physical Surface("plate") = {1:4}; Physical Surface("shot") = {9};
Physical Curve("axis") = {21, 34}; Physical Curve("rim") = {25};
Physical Curve("plate_skin") = {1, 2, 3, 4, 11, 12, 13, 14}; Physical Curve("shot_skin") = {31, 32};
Physical Curve("tail") = {33};
