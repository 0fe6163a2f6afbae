// A bar along x that hits a second bar, with a third one behind it, a wall, or nothing of the mesh (a rigid plane).
DefineConstant[
  second = 1,        // 0: none, 1: a bar, 2: a wall
  third = 0,         // 1: a bar behind the second one, as long as the first
  length = 1, width = 0.01,
  second_length = length,
  gap = 0,
  second_gap = 0,    // between the second and the third bar
  wall_length = 0.1, wall_width = 0.05,
  n = 200,           // cells along the bar
  n_width = 1,       // cells across the bar
  n_second = n       // cells along the second body
];
Macro Body
  // A rectangle from (x0, -w/2) to (x0 + l, w/2) with m x m_width cells.
  p = newp;
  Point(p) = {x0, -w / 2, 0};
  Point(p + 1) = {x0 + l, -w / 2, 0};
  Point(p + 2) = {x0 + l, w / 2, 0};
  Point(p + 3) = {x0, w / 2, 0};
  c = newl;
  Line(c) = {p, p + 1};
  Line(c + 1) = {p + 1, p + 2};
  Line(c + 2) = {p + 2, p + 3};
  Line(c + 3) = {p + 3, p};
  Transfinite Curve {c, c + 2} = m + 1;
  Transfinite Curve {c + 1, c + 3} = m_width + 1;
  s = news;
  Curve Loop(s) = {c, c + 1, c + 2, c + 3};
  Plane Surface(s) = {s};
  Transfinite Surface {s};
  Recombine Surface {s};
Return

x0 = 0; l = length; w = width; m = n; m_width = n_width;
Call Body;
Physical Surface("bar") = {s};
Physical Curve("bar_left") = {c + 3};
Physical Curve("bar_right") = {c + 1};
Physical Curve("bar_sides") = {c, c + 2};
If (second > 0)
  x0 = length + gap;
  m = n_second;
  l = second_length;
  If (second == 2)
    l = wall_length; w = wall_width;
    m_width = Ceil(n_width * wall_width / width - 0.01);
  EndIf
  Call Body;
  If (second == 1)
    Physical Surface("second_bar") = {s};
  Else
    Physical Surface("wall") = {s};
  EndIf
  Physical Curve("second_left") = {c + 3};
  Physical Curve("second_right") = {c + 1};
  Physical Curve("second_sides") = {c, c + 2};
EndIf
If (third)
  x0 += second_length + second_gap;
  m = n;
  l = length;
  Call Body;
  Physical Surface("third_bar") = {s};
  Physical Curve("third_left") = {c + 3};
  Physical Curve("third_right") = {c + 1};
  Physical Curve("third_sides") = {c, c + 2};
EndIf
