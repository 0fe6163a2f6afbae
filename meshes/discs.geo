// Two discs beside each other, the second one shifted by `offset` in y. Each is a square with four round caps.
DefineConstant[
  radius = 10,
  second_radius = radius,
  gap = 1,          // between their nearest points
  offset = 10,      // of the second centre in y
  n = 8,            // cells along a quarter of the circumference
  second_n = n + 1,
  n_radial = Ceil(n / 2), second_n_radial = Ceil(second_n / 2)
];
apart = Sqrt((radius + second_radius + gap)^2 - offset^2); // of the centres in x
Macro Disc
  // Centre (x0, y0), radius r, m cells along a quarter, q across a cap; its numbers start at f.
  Point(f) = {x0, y0, 0};
  For i In {1 : 4}
    c = Cos(Pi / 4 + i * Pi / 2); d = Sin(Pi / 4 + i * Pi / 2);
    Point(f + i) = {x0 + r * c, y0 + r * d, 0};
    Point(f + 4 + i) = {x0 + 0.5 * r * c, y0 + 0.5 * r * d, 0};
  EndFor
  For i In {1 : 4}
    j = 1 + i % 4;
    Circle(f + i) = {f + i, f, f + j};
    Line(f + 4 + i) = {f + 4 + i, f + 4 + j};
    Line(f + 8 + i) = {f + i, f + 4 + i};
  EndFor
  Transfinite Curve {f + 1 : f + 8} = m + 1;
  Transfinite Curve {f + 9 : f + 12} = q + 1;
  For i In {1 : 4}
    j = 1 + i % 4;
    Curve Loop(f + i) = {f + i, f + 8 + j, -(f + 4 + i), -(f + 8 + i)};
    Plane Surface(f + i) = {f + i};
  EndFor
  Curve Loop(f + 5) = {f + 5 : f + 8};
  Plane Surface(f + 5) = {f + 5};
  Transfinite Surface {f + 1 : f + 5};
  Recombine Surface {f + 1 : f + 5};
Return

f = 100; x0 = 0; y0 = 0; r = radius; m = n; q = n_radial;
Call Disc;
f = 200; x0 = apart; y0 = offset; r = second_radius; m = second_n; q = second_n_radial;
Call Disc;
Physical Surface("disc") = {101 : 105};
Physical Curve("disc_side") = {101 : 104};
Physical Surface("second_disc") = {201 : 205};
Physical Curve("second_side") = {201 : 204};
