// Beam on a wedge: a beam [0, length] x [0, height] with a slit in its lower side, whose right part is pushed from below
// by a wedge with a short upper edge. Millimetres. Quadrilaterals on curves of fixed division, so that every cell of the
// beam is a rectangle.
DefineConstant[
  length = 13,
  height = 5,
  notch = 2.5,       // x of the centre line of the slit
  width = 0.25,      // of the slit
  depth = 1.5,
  touch = 12,        // x of the right end of the upper edge of the wedge
  edge = 0.3,        // length of that edge
  band = 0.75,       // fine cells on either side of the centre line of the slit
  h_notch = 0.125,   // there, and the rows of all of the beam
  h_far = 0.5,       // largest size
  h_left = 0.25,     // clamped end
  h_contact = 0.05,  // upper edge of the wedge
  h_under = 0.125,   // beam above the wedge
  h_factor = 1,      // multiplies all sizes; 0.5 for a mesh of half the size
  wedge = 1          // 0: the beam alone, with the point tip at (touch, 0)
];
hn = h_factor * h_notch;
hf = h_factor * h_far;
hc = h_factor * h_contact;
hu = h_factor * h_under;
hl = h_factor * h_left;
he = Min(hf, 2 * hu);

// Beam: columns and rows of points; column k lies between x[k] and x[k+1], its cells grow from first[k] to last[k].
x[] = {0, notch - band, notch - width / 2, notch + width / 2, notch + band, notch + band + 1.25, touch - 1.5,
       touch - 0.6, touch, touch + 0.3, length};
first[] = {hl, hn, hn, hn, hn, hf, hf, hu, hu, hu};
last[] = {hn, hn, hn, hn, hf, hf, hu, hu, hu, he};
y[] = {0, depth, height};
rows[] = {Ceil(depth / hn - 0.01), Ceil((height - depth) / hn - 0.01)};
columns = #first[];
beam[] = {};
slit = 2; // the column below whose upper row there is nothing
For j In {0 : 2}
  For k In {0 : columns}
    Point(1000 + 100 * j + k) = {x[k], y[j], 0};
  EndFor
EndFor
For j In {0 : 2}
  For k In {0 : columns - 1}
    If (j > 0 || k != slit)
      a = first[k];
      b = last[k];
      span = x[k + 1] - x[k];
      If (Fabs(a - b) < 1e-6 * a)
        cells = Ceil(span / a - 0.01);
        ratio = 1;
      Else
        cells = Max(2, Ceil(span * Log(b / a) / (b - a) - 0.01));
        ratio = (b / a)^(1 / (cells - 1));
      EndIf
      Line(2000 + 100 * j + k) = {1000 + 100 * j + k, 1001 + 100 * j + k};
      Transfinite Curve {2000 + 100 * j + k} = cells + 1 Using Progression ratio;
    EndIf
  EndFor
EndFor
For j In {0 : 1}
  For k In {0 : columns}
    Line(3000 + 100 * j + k) = {1000 + 100 * j + k, 1100 + 100 * j + k};
    Transfinite Curve {3000 + 100 * j + k} = rows[j] + 1;
  EndFor
  For k In {0 : columns - 1}
    If (j > 0 || k != slit)
      Curve Loop(4000 + 100 * j + k) = {2000 + 100 * j + k, 3001 + 100 * j + k, -(2100 + 100 * j + k),
                                        -(3000 + 100 * j + k)};
      Plane Surface(4000 + 100 * j + k) = {4000 + 100 * j + k};
      beam[] += {4000 + 100 * j + k};
    EndIf
  EndFor
EndFor

// Wedge: cells grow downwards from its short upper edge.
If (wedge)
  Point(1) = {touch - edge - 0.7, -1.5, 0};
  Point(2) = {touch, -1.5, 0};
  Point(3) = {touch, 0, 0};
  Point(4) = {touch - edge, 0, 0};
  Line(1) = {1, 2};
  Line(2) = {3, 2};
  Line(3) = {3, 4};
  Line(4) = {4, 1};
  growth = 1.2^h_factor;
  across = Ceil(edge / hc - 0.01);
  down = Ceil(Log(1 + 1.5 * (growth - 1) / hc) / Log(growth));
  Transfinite Curve {1, 3} = across + 1;
  Transfinite Curve {2, 4} = down + 1 Using Progression growth;
  Curve Loop(1) = {1, -2, 3, 4};
  Plane Surface(1) = {1};
EndIf

Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("beam") = beam[];
Physical Curve("beam_left") = {3000, 3100};
Physical Curve("beam_bottom") = {2000 : 2000 + slit - 1, 2000 + slit + 1 : 2000 + columns - 1};
If (wedge)
  Physical Surface("wedge") = {1};
  Physical Curve("wedge_top") = {3};
  Physical Curve("wedge_right") = {2};
  Physical Curve("wedge_bottom") = {1};
Else
  Physical Point("tip") = {1008};
EndIf
