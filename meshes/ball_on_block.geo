// A quarter of a half ball (flat top) on a block, x = 0 and z = 0 are planes of symmetry; tetrahedra, mm.
DefineConstant[ R=10, w=6, h=6, near=0.12, gap=0 ];
SetFactory("OpenCASCADE");
Sphere(1)={0,R+gap,0,R}; Box(2)={0,gap,0,R,R,R};
v()=BooleanIntersection{ Volume{1}; Delete; }{ Volume{2}; Delete; };
Box(10)={0,-h,0,w,h,w};
Field[1]=MathEval; Field[1].F=Sprintf("Max(%g, 0.35*(Sqrt(x*x+y*y+z*z)-0.4)+%g)",near,near);
Background Field=1; Mesh.MeshSizeExtendFromBoundary=0; Mesh.MeshSizeFromPoints=0;
e=1e-3;
Physical Volume("ball")={v(0)}; Physical Volume("block")={10};
Physical Surface("ground")=Surface In BoundingBox{-e,-h-e,-e,w+e,-h+e,w+e};
Physical Surface("block_top")=Surface In BoundingBox{-e,-e,-e,w+e,e,w+e};
Physical Surface("top")=Surface In BoundingBox{-e,R+gap-e,-e,R+e,R+gap+e,R+e};
Physical Surface("left")=Surface In BoundingBox{-e,-h-e,-e,e,R+gap+e,R+e};
Physical Surface("back")=Surface In BoundingBox{-e,-h-e,-e,R+e,R+gap+e,e};
f()=Boundary{ Volume{v(0)}; }; g()=Surface In BoundingBox{-e,R+gap-e,-e,R+e,R+gap+e,R+e};
l()=Surface In BoundingBox{-e,-h-e,-e,e,R+gap+e,R+e}; b()=Surface In BoundingBox{-e,-h-e,-e,R+e,R+gap+e,e};
f()-=g(); f()-=l(); f()-=b();
Physical Surface("skin")=f();
