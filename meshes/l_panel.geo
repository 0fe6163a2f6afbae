// An L: a square of the side 2 size without its lower right quarter. Cells are h wide where the crack from the inner corner
// will run, 4 h elsewhere; what is right of x = 1.6 size, with the loaded place, is a region of its own.
DefineConstant[
  size = 250,
  h = 4
];
load = 1.88 * size; pad = 0.04 * size;
Point(1) = {0, 0, 0};
Point(2) = {size, 0, 0};
Point(3) = {size, size, 0};
Point(4) = {1.6 * size, size, 0};
Point(5) = {load - pad / 2, size, 0};
Point(6) = {load + pad / 2, size, 0};
Point(7) = {2 * size, size, 0};
Point(8) = {2 * size, 2 * size, 0};
Point(9) = {1.6 * size, 2 * size, 0};
Point(10) = {0, 2 * size, 0};
For i In {1 : 9}
  Line(i) = {i, i + 1};
EndFor
Line(10) = {10, 1};
Line(11) = {4, 9};
Curve Loop(1) = {1, 2, 3, 11, 9, 10};
Plane Surface(1) = {1};
Curve Loop(2) = {4, 5, 6, 7, 8, -11};
Plane Surface(2) = {2};
Field[1] = Box;
Field[1].XMin = 0; Field[1].XMax = 1.06 * size;
Field[1].YMin = 0.96 * size; Field[1].YMax = 1.5 * size;
Field[1].VIn = h; Field[1].VOut = 4 * h; Field[1].Thickness = 0.3 * size;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("panel") = {1};
Physical Surface("arm") = {2};
Physical Curve("foot") = {1};
Physical Curve("place") = {5};
