// A penny-shaped crack of radius a = 1 in a large body, cut along its planes of symmetry: in the plane the section of a
// cylinder above the crack (y >= 0), in space an eighth of a block (z >= 0).
// Region "body"; sides: face (of the crack), ahead (the plane of the crack outside of it), top, and axis, or x0 and y0 (planes of symmetry).
DefineConstant[
  dim = 2,          // 2 or 3
  R = 6 * (4 - dim), // size of the body
  h = 0.02          // cells at the front
];
Point(1) = {0, 0, 0, 4 * h};
Point(2) = {1, 0, 0, h};
If (dim == 2)
  Point(3) = {R, 0, 0, 1};
  Point(4) = {R, R, 0, 1};
  Point(5) = {0, R, 0, 1};
  For k In {1 : 5}
    Line(k) = {k, 1 + (k % 5)};
  EndFor
  Curve Loop(1) = {1 : 5};
  Plane Surface(1) = {1};
  Physical Surface("body") = {1};
  Physical Curve("face") = {1};
  Physical Curve("ahead") = {2};
  Physical Curve("top") = {4};
  Physical Curve("axis") = {5};
Else
  Point(3) = {0, 1, 0};
  Circle(1) = {2, 1, 3};
  Line(2) = {1, 2};
  Line(3) = {3, 1};
  For k In {0 : 1}
    Point(10 * k + 4) = {R, 0, k * R};
    Point(10 * k + 5) = {R, R, k * R};
    Point(10 * k + 6) = {0, R, k * R};
  EndFor
  Point(11) = {0, 0, R};
  Line(4) = {2, 4};
  Line(5) = {4, 5};
  Line(6) = {5, 6};
  Line(7) = {6, 3};
  Line(11) = {11, 14};
  Line(12) = {14, 15};
  Line(13) = {15, 16};
  Line(14) = {16, 11};
  Line(21) = {1, 11};
  Line(22) = {4, 14};
  Line(23) = {5, 15};
  Line(24) = {6, 16};
  Curve Loop(1) = {2, 1, 3};
  Curve Loop(2) = {4, 5, 6, 7, -1};
  Curve Loop(3) = {11 : 14};
  Curve Loop(4) = {2, 4, 22, -11, -21};
  Curve Loop(5) = {5, 23, -12, -22};
  Curve Loop(6) = {6, 24, -13, -23};
  Curve Loop(7) = {7, 3, 21, -14, -24};
  For k In {1 : 7}
    Plane Surface(k) = {k};
  EndFor
  Surface Loop(1) = {1 : 7};
  Volume(1) = {1};
  Physical Volume("body") = {1};
  Physical Surface("face") = {1};
  Physical Surface("ahead") = {2};
  Physical Surface("top") = {3};
  Physical Surface("y0") = {4};
  Physical Surface("x0") = {7};
  // Cells grow with the distance from the front.
  Field[1] = Distance;
  Field[1].CurvesList = {1};
  Field[1].NumPointsPerCurve = 200;
  Field[2] = MathEval;
  Field[2].F = Sprintf("%g + 0.35 * F1", h);
  Background Field = 2;
  Mesh.MeshSizeExtendFromBoundary = 0;
  Mesh.MeshSizeMax = 1.5;
EndIf
