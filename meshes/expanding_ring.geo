// A thin ring whose outside is uneven: its thickness varies from cell to cell by up to `uneven` of itself, at random, the same
// in each mesh of one seed.
DefineConstant[
  radius = 1.97, thickness = 0.08,
  uneven = 0.02,
  n_around = 2400,  // cells around, even
  n_through = 8,
  seed = 1
];
random = seed;
For i In {0 : n_around - 1}
  angle = 2 * Pi * i / n_around;
  random = Fmod(16807 * random, 2147483647); // Park and Miller
  outside = radius + thickness * (1 - uneven * random / 2147483647);
  Point(2 * i + 1) = {radius * Cos(angle), radius * Sin(angle), 0};
  Point(2 * i + 2) = {outside * Cos(angle), outside * Sin(angle), 0};
EndFor
For i In {0 : n_around - 1}
  j = (i + 1) % n_around;
  Line(2 * i + 1) = {2 * i + 1, 2 * j + 1};
  Line(2 * i + 2) = {2 * i + 2, 2 * j + 2};
EndFor
half = n_around / 2;
across = 2 * n_around + 1;
Line(across) = {1, 2};
Line(across + 1) = {2 * half + 1, 2 * half + 2};
Transfinite Curve {1 : 2 * n_around} = 2;
Transfinite Curve {across, across + 1} = n_through + 1;
For k In {0 : 1}
  inner[] = {}; outer[] = {};
  For i In {k * half : (k + 1) * half - 1}
    inner[] += {2 * i + 1};
    outer[] += {2 * i + 2};
  EndFor
  back[] = {};
  For i In {1 : #inner[]}
    back[] += {-inner[#inner[] - i]};
  EndFor
  first = k == 0 ? across : across + 1;
  last = k == 0 ? across + 1 : across;
  Curve Loop(k + 1) = {first, outer[], -last, back[]};
  Plane Surface(k + 1) = {k + 1};
  f = 2 * k * half;
  l = 2 * ((k + 1) * half % n_around);
  Transfinite Surface {k + 1} = {f + 1, f + 2, l + 2, l + 1};
  Recombine Surface {k + 1};
EndFor
Physical Surface("ring") = {1, 2};
