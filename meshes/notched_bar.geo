// A quarter of a round bar with a round notch, x = R, y = Z: the axis at x = 0, the plane of symmetry at y = 0.
DefineConstant[
  radius = 3, length = 6, // of the bar, half of its length
  ligament = 2,           // radius at the notch
  notch = 2,              // radius of the notch
  nr = 12, nz = 12, nl = 8 // cells across, along the notch, beyond it
];
rise = Sqrt(notch^2 - (notch + ligament - radius)^2);
Point(1) = {0, 0, 0}; Point(2) = {ligament, 0, 0}; Point(3) = {radius, rise, 0}; Point(4) = {0, rise, 0};
Point(5) = {radius, length, 0}; Point(6) = {0, length, 0}; Point(7) = {ligament + notch, 0, 0};
Line(1) = {1, 2}; Circle(2) = {2, 7, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {3, 5}; Line(6) = {5, 6}; Line(7) = {6, 4};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Curve Loop(2) = {-3, 5, 6, 7}; Plane Surface(2) = {2};
Transfinite Curve {1, 3, 6} = nr + 1;
Transfinite Curve {2} = nz + 1 Using Progression 1.06;
Transfinite Curve {4} = nz + 1 Using Progression 1 / 1.06;
Transfinite Curve {5} = nl + 1 Using Progression 1.2;
Transfinite Curve {7} = nl + 1 Using Progression 1 / 1.2;
Transfinite Surface {1}; Transfinite Surface {2}; Recombine Surface {1, 2};
Physical Surface("bar") = {1, 2};
Physical Curve("middle") = {1}; Physical Curve("notch") = {2}; Physical Curve("grip") = {6};
Physical Curve("axis") = {4, 7};
