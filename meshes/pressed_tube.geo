// A quarter of a tube between two plates: x = 0 and y = 0 are planes of symmetry, the plate comes down along y.
SetFactory("OpenCASCADE");
DefineConstant[
  radius = 25, // of the middle of the wall
  wall = 3, length = 30,
  h = 2.4
];
r = radius + wall/2;
e = 1e-3;
Cylinder(1) = {0, 0, 0, 0, 0, length, r};
Cylinder(2) = {0, 0, 0, 0, 0, length, r - wall};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Box(4) = {0, 0, 0, 2*r, 2*r, length};
BooleanIntersection(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };
Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Physical Volume("tube") = {5};
left() = Surface In BoundingBox{-e, -e, -e, e, r + e, length + e};
low() = Surface In BoundingBox{-e, -e, -e, r + e, e, length + e};
front() = Surface In BoundingBox{-e, -e, -e, r + e, r + e, e};
back() = Surface In BoundingBox{-e, -e, length - e, r + e, r + e, length + e};
skin() = Surface{:};
skin() -= left(); skin() -= low(); skin() -= front(); skin() -= back();
Physical Surface("left") = {left()};
Physical Surface("low") = {low()};
Physical Surface("ends") = {front(), back()};
Physical Surface("skin") = {skin()};
