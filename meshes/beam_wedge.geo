// Beam on a wedge: a beam [0, length] x [0, height] with a slit in its lower side, whose right part is pushed from below
// by a wedge with a short upper edge. Millimetres. Squares in a band above the slit, where the crack runs; quadrilaterals
// that grow with the distance from there and from the wedge elsewhere.
DefineConstant[
  length = 56,
  height = 21,
  notch = 10,        // x of the centre line of the slit
  width = 0.25,      // of the slit
  depth = 6,
  touch = 51,        // x of the right end of the upper edge of the wedge
  edge = 1.2,        // length of that edge
  band = 0.5,        // squares on either side of the centre line of the slit
  h_notch = 0.125,   // their size
  h_far = 3,         // largest size
  h_contact = 0.2,   // upper edge of the wedge
  h_under = 0.3,     // beam above the wedge
  growth = 0.6,      // of the size with the distance
  h_factor = 1       // multiplies all sizes; 0.5 for a mesh of half the size
];
hn = h_factor * h_notch;
hf = h_factor * h_far;
hc = h_factor * h_contact;
hu = h_factor * h_under;

// Cells along a curve of length `span` whose sizes grow geometrically from `first` to `last`: `cells` and their `ratio`.
// Their number has the parity `odd`: a surface of quadrilaterals needs an even number of edges around it.
Macro Divide
  If (Fabs(first - last) < 1e-6 * first)
    cells = Ceil(span / first - 0.01);
  Else
    cells = Ceil(span * Log(last / first) / (last - first) - 0.01);
  EndIf
  cells = Max(2, cells);
  cells += (cells + odd) % 2;
  ratio = (last / first)^(1 / (cells - 1));
Return

// Beam, around the part left of the band, then around the part right of it. Along its edges the cells reach the largest
// size as fast as inside.
crack = Min((hf - hn) / growth, length / 4);
under = Min((hf - hu) / growth, length / 4);
x[] = {0, notch - width / 2, notch - width / 2, notch - band, notch - band, 0,
       notch + band, notch + band + crack, length, length, touch, touch - edge, touch - edge - under, notch + width / 2,
       notch + width / 2, notch + band};
y[] = {0, 0, depth, depth, height, height, height, height, height, 0, 0, 0, 0, 0, depth, depth};
For k In {0 : 15}
  Point(100 + k) = {x[k], y[k], 0};
EndFor
Point(116) = {notch - width / 2, height, 0};
Point(117) = {notch + width / 2, height, 0};

rows = Ceil((height - depth) / hn - 0.01);
aside = Max(1, Ceil((band - width / 2) / hn - 0.01));
across = Max(1, Ceil(width / hn - 0.01));
hm = Min(hf, hn + growth * depth); // mouth of the slit
begin[] = {hf, hm, 0, 0, hn, hf, hn, hf, hf, hf, hu, hu, hf, hm, 0, 0};
end[] = {hm, hn, 0, 0, hf, hf, hf, hf, hf, hu, hu, hf, hm, hn, 0, 0};
from[] = {0 : 15};
to[] = {1, 2, 3, 4, 5, 0, 7, 8, 9, 10, 11, 12, 13, 14, 15, 6};
For k In {0 : 15}
  Line(200 + k) = {100 + from[k], 100 + to[k]};
  If (begin[k] > 0)
    span = Hypot(x[to[k]] - x[from[k]], y[to[k]] - y[from[k]]);
    first = begin[k];
    last = end[k];
    odd = (k == 1 || k == 13) ? (rows + aside) % 2 : 0;
    Call Divide;
    Transfinite Curve {200 + k} = cells + 1 Using Progression ratio;
  EndIf
EndFor
Line(216) = {102, 114};
Line(217) = {102, 116};
Line(218) = {114, 117};
Line(219) = {104, 116};
Line(220) = {116, 117};
Line(221) = {117, 106};
Transfinite Curve {203, 215, 217, 218} = rows + 1;
Transfinite Curve {202, 214, 219, 221} = aside + 1;
Transfinite Curve {216, 220} = across + 1;
Curve Loop(300) = {200 : 205};
Curve Loop(301) = {206 : 215};
Curve Loop(302) = {-202, 217, -219, -203};
Curve Loop(303) = {216, 218, -220, -217};
Curve Loop(304) = {214, 215, -221, -218};
For k In {0 : 4}
  Plane Surface(300 + k) = {300 + k};
EndFor
Transfinite Surface {302, 303, 304};

Field[1] = Distance;
Field[1].CurvesList = {202, 203, 214, 215};
Field[1].NumPointsPerCurve = 400;
Field[2] = MathEval;
Field[2].F = Sprintf("Min(%g, %g + %g * F1)", hf, hn, growth);
Field[3] = Distance;
Field[3].CurvesList = {210};
Field[3].NumPointsPerCurve = 50;
Field[4] = MathEval;
Field[4].F = Sprintf("Min(%g, %g + %g * F3)", hf, hu, growth);
Field[5] = Min;
Field[5].FieldsList = {2, 4};
Background Field = 5;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;

// Wedge: cells grow downwards from its short upper edge.
deep = 5 * edge;
Point(1) = {touch - 10 / 3 * edge, -deep, 0};
Point(2) = {touch, -deep, 0};
Point(3) = {touch, 0, 0};
Point(4) = {touch - edge, 0, 0};
Line(1) = {1, 2};
Line(2) = {3, 2};
Line(3) = {3, 4};
Line(4) = {4, 1};
taller = 1.2^h_factor;
Transfinite Curve {1, 3} = Ceil(edge / hc - 0.01) + 1;
Transfinite Curve {2, 4} = Ceil(Log(1 + deep * (taller - 1) / hc) / Log(taller)) + 1 Using Progression taller;
Curve Loop(1) = {1, -2, 3, 4};
Plane Surface(1) = {1};
Transfinite Surface {1};

Recombine Surface "*";
Physical Surface("beam") = {300 : 304};
Physical Curve("beam_left") = {205};
Physical Curve("beam_bottom") = {200, 209, 210, 211, 212};
Physical Surface("wedge") = {1};
Physical Curve("wedge_top") = {3};
Physical Curve("wedge_right") = {2};
Physical Curve("wedge_bottom") = {1};
