// A block [0,4] x [0,2] with a notch from below in its middle, a slit with parallel flanks or a wedge; all of its boundary
// is one surface.
DefineConstant[
  h = 0.08,      // cell size
  width = 0.05,  // of the notch at its mouth; 0: no notch
  depth = 1.2,
  wedge = 0      // 1: the flanks meet at the top
];
Point(1) = {0, 0, 0, h};
Point(6) = {4, 0, 0, h};
Point(7) = {4, 2, 0, h};
Point(8) = {0, 2, 0, h};
Line(1) = {6, 7};
Line(2) = {7, 8};
Line(3) = {8, 1};
If (width == 0)
  Line(4) = {1, 6};
  outline[] = {1 : 4};
Else
  Point(2) = {2 - width / 2, 0, 0, h};
  Point(5) = {2 + width / 2, 0, 0, h};
  Line(4) = {1, 2};
  Line(5) = {5, 6};
  If (wedge == 1)
    Point(3) = {2, depth, 0, h};
    Line(6) = {2, 3};
    Line(7) = {3, 5};
    outline[] = {1 : 4, 6, 7, 5};
  Else
    Point(3) = {2 - width / 2, depth, 0, h};
    Point(4) = {2 + width / 2, depth, 0, h};
    Line(6) = {2, 3};
    Line(7) = {3, 4};
    Line(8) = {4, 5};
    outline[] = {1 : 4, 6, 7, 8, 5};
  EndIf
EndIf
Curve Loop(1) = {outline[]};
Plane Surface(1) = {1};
Physical Surface("block") = {1};
Physical Curve("skin") = {outline[]};
Physical Curve("left") = {3};
Physical Curve("right") = {1};
