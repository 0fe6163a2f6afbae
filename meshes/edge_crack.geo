// A square or rectangle with a slit from the middle of its left side, to its centre unless `slit` says otherwise, whose
// flanks are two lines at the same place.
DefineConstant[
  width = 1, height = 1,
  slit = width / 2, // its length
  n = 40            // cells along the width
];
w = width; h = height; m = Round(n * h / (2 * w)); // cells along half the height
along = Round(n * slit / w);                       // cells along the slit
Point(1) = {0, 0, 0}; Point(2) = {w, 0, 0}; Point(3) = {w, h / 2, 0}; Point(4) = {slit, h / 2, 0};
Point(5) = {0, h / 2, 0}; Point(6) = {0, h / 2, 0}; Point(7) = {0, h, 0}; Point(8) = {w, h, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 1};
Line(6) = {4, 6}; Line(7) = {6, 7}; Line(8) = {7, 8}; Line(9) = {8, 3};
Curve Loop(1) = {1, 2, 3, 4, 5}; Plane Surface(1) = {1};
Curve Loop(2) = {-3, -9, -8, -7, -6}; Plane Surface(2) = {2};
Transfinite Curve {1, 8} = n + 1;
Transfinite Curve {3} = n - along + 1;
Transfinite Curve {4, 6} = along + 1;
Transfinite Curve {2, 5, 7, 9} = m + 1;
Transfinite Surface {1} = {1, 2, 3, 5};
Transfinite Surface {2} = {6, 3, 8, 7};
Recombine Surface {1, 2};
Physical Surface("plate") = {1, 2};
Physical Curve("bottom") = {1}; Physical Curve("top") = {8};
Physical Curve("sides") = {2, 5, 7, 9}; Physical Curve("flank") = {4}; // the lower one
Physical Point("end") = {3}; // of the line that the slit is on
