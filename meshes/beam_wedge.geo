// Beam on a wedge: a notched beam [0,6] x [0,2] whose right part is pushed from below by a wedge with a short edge.
// Millimetres. Quadrilaterals on curves of fixed division, so that every cell of the beam is a rectangle.
DefineConstant[
  h_notch = 0.125,   // beam for x <= 2: notch, crack path
  h_far = 0.25,      // largest size
  h_contact = 0.05,  // upper edge of the wedge
  h_under = 0.1,     // beam above the wedge
  h_factor = 1,      // multiplies all sizes; 0.5 for a mesh of half the size
  depth = 0.4,       // of the slit
  wedge = 1          // 0: the beam alone, with the point tip where the wedge would touch (beam_push.geo)
];
hn = h_factor * h_notch;
hf = h_factor * h_far;
hc = h_factor * h_contact;
hu = h_factor * h_under;

// Beam: columns and rows of points; column k lies between x[k] and x[k+1], its cells grow from first[k] to last[k].
x[] = {0, 0.875, 1.125, 2, 3.25, 4.5, 5, 5.3, 6};
first[] = {hn, hn, hn, hn, hf, hu, hu, hu};
last[] = {hn, hn, hn, hf, hu, hu, hu, Min(hf, 1.75 * hu)};
y[] = {0, depth, 2};
rows[] = {Ceil(depth / Min(hn, hu) - 0.01), Ceil((2 - depth) / hn - 0.01)};
For j In {0 : 2}
  For k In {0 : 8}
    Point(100 + 10 * j + k) = {x[k], y[j], 0};
  EndFor
EndFor
For j In {0 : 2}
  For k In {0 : 7}
    If (j > 0 || k != 1)
      a = first[k];
      b = last[k];
      length = x[k + 1] - x[k];
      If (Fabs(a - b) < 1e-6 * a)
        cells = Ceil(length / a - 0.01);
        ratio = 1;
      Else
        cells = Max(2, Ceil(length * Log(b / a) / (b - a) - 0.01));
        ratio = (b / a)^(1 / (cells - 1));
      EndIf
      Line(200 + 10 * j + k) = {100 + 10 * j + k, 101 + 10 * j + k};
      Transfinite Curve {200 + 10 * j + k} = cells + 1 Using Progression ratio;
    EndIf
  EndFor
EndFor
For j In {0 : 1}
  For k In {0 : 8}
    Line(300 + 10 * j + k) = {100 + 10 * j + k, 110 + 10 * j + k};
    Transfinite Curve {300 + 10 * j + k} = rows[j] + 1;
  EndFor
  For k In {0 : 7}
    If (j > 0 || k != 1) // the slit is left open
      Curve Loop(400 + 10 * j + k) = {200 + 10 * j + k, 301 + 10 * j + k, -(210 + 10 * j + k), -(300 + 10 * j + k)};
      Plane Surface(400 + 10 * j + k) = {400 + 10 * j + k};
    EndIf
  EndFor
EndFor

// Wedge: cells grow downwards from its short upper edge.
If (wedge)
  Point(1) = {4.2, -1.5, 0};
  Point(2) = {5, -1.5, 0};
  Point(3) = {5, 0, 0};
  Point(4) = {4.9, 0, 0};
  Line(1) = {1, 2};
  Line(2) = {3, 2};
  Line(3) = {3, 4};
  Line(4) = {4, 1};
  growth = 1.2^h_factor;
  across = Ceil(0.1 / hc - 0.01);
  down = Ceil(Log(1 + 1.5 * (growth - 1) / hc) / Log(growth));
  Transfinite Curve {1, 3} = across + 1;
  Transfinite Curve {2, 4} = down + 1 Using Progression growth;
  Curve Loop(1) = {1, -2, 3, 4};
  Plane Surface(1) = {1};
EndIf

Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("beam") = {400, 402 : 407, 410 : 417};
Physical Curve("beam_left") = {300, 310};
Physical Curve("beam_bottom") = {200, 202 : 207};
If (wedge)
  Physical Surface("wedge") = {1};
  Physical Curve("wedge_top") = {3};
  Physical Curve("wedge_right") = {2};
  Physical Curve("wedge_bottom") = {1};
Else
  Physical Point("tip") = {106};
EndIf
