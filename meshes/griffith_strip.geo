// A strip that is clamped along its upper and lower edge, with a slot on its middle line: far ahead of the slot the
// energy of each length is the same, so that a crack that starts runs through. One row of cells continues the slot.
DefineConstant[
  length = 3.5, height = 2, slot = 1.2,
  h = 0.01,                                // of cells on the crack's way; the slot is as high
  coarse = 8                               // cells at the edges are so much longer
];
half = height / 2 - h / 2;
// Rows whose heights grow from h by a constant factor up to the edge.
growth = 1 + h * (coarse - 1) / half;
rows = Ceil(Log(coarse) / Log(growth));
Point(1) = {0, -height / 2, 0};      Point(2) = {slot, -height / 2, 0};  Point(3) = {length, -height / 2, 0};
Point(4) = {0, -h / 2, 0};           Point(5) = {slot, -h / 2, 0};       Point(6) = {length, -h / 2, 0};
Point(7) = {0, h / 2, 0};            Point(8) = {slot, h / 2, 0};        Point(9) = {length, h / 2, 0};
Point(10) = {0, height / 2, 0};      Point(11) = {slot, height / 2, 0};  Point(12) = {length, height / 2, 0};
Line(1) = {1, 2};   Line(2) = {2, 3};   Line(3) = {4, 5};    Line(4) = {5, 6};
Line(5) = {7, 8};   Line(6) = {8, 9};   Line(7) = {10, 11};  Line(8) = {11, 12};
Line(9) = {4, 1};   Line(10) = {5, 2};  Line(11) = {6, 3};                       // away from the middle line
Line(12) = {7, 10}; Line(13) = {8, 11}; Line(14) = {9, 12};
Line(15) = {5, 8};  Line(16) = {6, 9};
Transfinite Curve {9, 10, 11, 12, 13, 14} = rows + 1 Using Progression growth;
Transfinite Curve {2, 4, 6, 8} = Round((length - slot) / h) + 1;
Transfinite Curve {15, 16} = 2;
before = Ceil(Log(coarse) / Log(1 + h * (coarse - 1) / slot));
Transfinite Curve {-1, -3, -5, -7} = before + 1 Using Progression 1 + h * (coarse - 1) / slot;
Curve Loop(1) = {3, 10, -1, -9};     Plane Surface(1) = {1};
Curve Loop(2) = {4, 11, -2, -10};    Plane Surface(2) = {2};
Curve Loop(3) = {4, 16, -6, -15};    Plane Surface(3) = {3};
Curve Loop(4) = {5, 13, -7, -12};    Plane Surface(4) = {4};
Curve Loop(5) = {6, 14, -8, -13};    Plane Surface(5) = {5};
Transfinite Surface {1, 2, 3, 4, 5};
Recombine Surface {1, 2, 3, 4, 5};
Physical Surface("strip") = {1, 2, 3, 4, 5};
Physical Curve("bottom") = {1, 2};
Physical Curve("top") = {7, 8};
