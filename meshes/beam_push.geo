// A short notched beam [0, length] x [0, height] with a shallow slit in its lower side; the point `tip` is (touch, 0).
// Millimetres. Quadrilaterals on curves of fixed division, so that every cell is a rectangle.
DefineConstant[
  length = 6,
  height = 2,
  notch = 1,         // x of the centre line of the slit
  width = 0.25,      // of the slit
  depth = 0.375,
  touch = 5,
  band = 0.875,      // fine cells on either side of the centre line of the slit
  h_notch = 0.125,   // there, and the rows of all of the beam
  h_far = 0.25,      // largest size
  h_left = 0.125,    // clamped end
  h_under = 0.125,   // around the tip
  h_factor = 1       // multiplies all sizes; 0.5 for a mesh of half the size
];
hn = h_factor * h_notch;
hf = h_factor * h_far;
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

Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("beam") = beam[];
Physical Curve("beam_left") = {3000, 3100};
Physical Curve("beam_bottom") = {2000 : 2000 + slit - 1, 2000 + slit + 1 : 2000 + columns - 1};
Physical Point("tip") = {1008};
