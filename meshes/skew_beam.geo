// A beam of 260 x 60 x 10 mm with a slot of the depth a = 20 in its middle, turned by `angle` about the vertical out of the plane
// that bending would choose. It rests on strips at x = -120 and 120 and is pressed on one in the middle. Tetrahedra, h wide where the crack runs.
SetFactory("OpenCASCADE");
DefineConstant[
  h = 0.6,
  angle = 45
];
length = 260; height = 60; thick = 10; depth = 20; span = 240; slot = 0.6; pad = 4;
Box(1) = {-length / 2, 0, -thick / 2, length, height, thick};
Box(2) = {-slot / 2, -1, -20, slot, depth + 1, 40};
Rotate {{0, 1, 0}, {0, 0, 0}, angle * Pi / 180} { Volume{2}; }
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
For i In {0 : 2}
  x = (i - 1) * span / 2 - pad / 2;
  y = i == 1 ? height : 0;
  p = newp;
  Point(p) = {x, y, -thick / 2};
  Point(p + 1) = {x + pad, y, -thick / 2};
  Point(p + 2) = {x + pad, y, thick / 2};
  Point(p + 3) = {x, y, thick / 2};
  l = newl;
  Line(l) = {p, p + 1}; Line(l + 1) = {p + 1, p + 2}; Line(l + 2) = {p + 2, p + 3}; Line(l + 3) = {p + 3, p};
  Curve Loop(100 + i) = {l : l + 3};
  Plane Surface(1000 + i) = {100 + i};
EndFor
BooleanFragments{ Volume{3}; Delete; }{ Surface{1000 : 1002}; Delete; }
e = 0.01;
left() = Surface In BoundingBox {-span / 2 - pad / 2 - e, -e, -thick / 2 - e, -span / 2 + pad / 2 + e, e, thick / 2 + e};
right() = Surface In BoundingBox {span / 2 - pad / 2 - e, -e, -thick / 2 - e, span / 2 + pad / 2 + e, e, thick / 2 + e};
load() = Surface In BoundingBox {-pad / 2 - e, height - e, -thick / 2 - e, pad / 2 + e, height + e, thick / 2 + e};
Physical Volume("beam") = {Volume{:}};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Surface("load") = {load()};
// The root of the slot runs from side to side at the angle, the crack turns towards x = 0.
wide = thick / 2 * Tan(angle * Pi / 180);
Field[1] = Box;
Field[1].XMin = -wide - 1; Field[1].XMax = wide + 1;
Field[1].YMin = depth - 1; Field[1].YMax = height;
Field[1].ZMin = -thick; Field[1].ZMax = thick;
Field[1].VIn = h; Field[1].VOut = 5; Field[1].Thickness = 40;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
