// A slab, the upper side of which is cooled: fine triangles as deep as cracks run, coarser ones below. They are irregular, so that no
// crack has a place of its own.
DefineConstant[
  width = 3, depth = 1.6, // mm
  fine = 0.8,             // depth of the fine triangles
  h = 0.016,              // their size
  growth = 0.1            // of the size below, per length
];
Point(1) = {0, 0, 0}; Point(2) = {width, 0, 0}; Point(3) = {width, depth, 0}; Point(4) = {0, depth, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + %g*0.5*((%g - y) + abs(%g - y))", h, growth, depth - fine, depth - fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;
Physical Surface("slab") = {1};
Physical Curve("bottom") = {1}; Physical Curve("right") = {2}; Physical Curve("cold") = {3}; Physical Curve("left") = {4};
