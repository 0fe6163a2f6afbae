// A whole disc that lies on a plate, pressed on the top of its rim: nothing but the contact holds it, and it may roll.
DefineConstant[ R = 10, half = 20, depth = 10, h = 0.4 ];
s = R / 2; top = R + Sqrt(R * R - s * s);
Point(1) = {0, R, 0};
Point(2) = {0, 0, 0}; Point(3) = {R, R, 0}; Point(4) = {s, top, 0}; Point(5) = {-s, top, 0}; Point(6) = {-R, R, 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 6}; Circle(5) = {6, 1, 2};
Curve Loop(1) = {1:5}; Plane Surface(1) = {1};
Point(11) = {-half, -depth, 0}; Point(12) = {half, -depth, 0}; Point(13) = {half, 0, 0}; Point(14) = {-half, 0, 0};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Line(14) = {14, 11};
Curve Loop(2) = {11:14}; Plane Surface(2) = {2};
Field[1] = MathEval; Field[1].F = Sprintf("%g + 0.15*Sqrt(x*x + y*y)", h); Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Physical Surface("disc") = {1}; Physical Surface("plate") = {2};
Physical Curve("load") = {3}; Physical Curve("rim") = {1, 2, 4, 5};
Physical Curve("plate_top") = {13}; Physical Curve("ground") = {11};
