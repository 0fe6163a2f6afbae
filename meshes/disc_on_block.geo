// quarter of a disc (R, flat top) on a block, x = 0 is a plane of symmetry, mm
DefineConstant[ R=10, w=12, hh=10, n=0.05, gap=0 ];
Point(1)={0,R+gap,0}; Point(2)={0,gap,0}; Point(3)={R,R+gap,0};
Circle(1)={2,1,3}; Line(3)={3,1}; Line(4)={1,2};
Curve Loop(1)={1,3,4}; Plane Surface(1)={1};
Point(11)={0,-hh,0}; Point(12)={w,-hh,0}; Point(13)={w,0,0}; Point(14)={0,0,0};
Line(11)={11,12}; Line(12)={12,13}; Line(13)={13,14}; Line(14)={14,11};
Curve Loop(2)={11:14}; Plane Surface(2)={2};
Field[1]=MathEval; Field[1].F=Sprintf("Max(%g, 0.25*(Sqrt(x*x+y*y)-0.5)+%g)",n,n);
Background Field=1; Mesh.MeshSizeExtendFromBoundary=0; Mesh.MeshSizeFromPoints=0;
Mesh.Algorithm=6;
Physical Surface("disc")={1}; Physical Surface("block")={2};
Physical Curve("top")={3}; Physical Curve("rim")={1}; Physical Curve("middle")={4,14};
Physical Curve("block_top")={13}; Physical Curve("ground")={11};
