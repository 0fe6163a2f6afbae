// Two leaves of a spring that lie on each other, 100 long and 2 high: regions "lower" and "upper",
// ends "lower_left", "upper_left", faces "lower_top", "upper_bottom", point "tip" at the upper corner of the upper one.
DefineConstant[ n_lower = 100, n_upper = 90, length = 100, height = 2, layers = 4 ];
n[] = {n_lower, n_upper};
For b In {0 : 1}
  f = 10 * b;
  Point(f + 1) = {0, height * b, 0};
  Point(f + 2) = {length, height * b, 0};
  Point(f + 3) = {length, height * (b + 1), 0};
  Point(f + 4) = {0, height * (b + 1), 0};
  For k In {1 : 4}
    Line(f + k) = {f + k, f + 1 + (k % 4)};
  EndFor
  Curve Loop(f + 1) = {f + 1 : f + 4};
  Plane Surface(f + 1) = {f + 1};
  Transfinite Curve {f + 1, f + 3} = n[b] + 1;
  Transfinite Curve {f + 2, f + 4} = layers + 1;
  Transfinite Surface {f + 1};
  Recombine Surface {f + 1};
EndFor
Physical Surface("lower") = {1};
Physical Surface("upper") = {11};
Physical Curve("lower_left") = {4};
Physical Curve("upper_left") = {14};
Physical Curve("lower_top") = {3};
Physical Curve("upper_bottom") = {11};
Physical Point("tip") = {13};
