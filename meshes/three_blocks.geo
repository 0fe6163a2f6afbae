// three blocks, one on the other, non-matching, mm
DefineConstant[ a=10, n=4, gap=0, d3=0 ];
For i In {0:2}
  w=a*(3-i*0.5); x0=-w/2+0.3*i; y0=i*(a+gap); m=n*(3-i)/1+i;
  p=newp; Point(p)={x0,y0,0}; Point(p+1)={x0+w,y0,0}; Point(p+2)={x0+w,y0+a,0}; Point(p+3)={x0,y0+a,0};
  c=newl; Line(c)={p,p+1}; Line(c+1)={p+1,p+2}; Line(c+2)={p+2,p+3}; Line(c+3)={p+3,p};
  Transfinite Curve{c,c+2}=m+2; Transfinite Curve{c+1,c+3}=n+1;
  s=news; Curve Loop(s)={c:c+3}; Plane Surface(s)={s}; Transfinite Surface{s}; Recombine Surface{s};
  S[i]=s; C[i]=c;
EndFor
If(d3==0)
For i In {0:2}
 Physical Surface(Sprintf("b%g",i))={S[i]};
 Physical Curve(Sprintf("bottom%g",i))={C[i]}; Physical Curve(Sprintf("top%g",i))={C[i]+2};
EndFor
Else
For i In {0:2}
 v[]=Extrude{0,0,a}{Surface{S[i]}; Layers{n-1+i}; Recombine;};
 Physical Volume(Sprintf("b%g",i))={v[1]};
 Physical Surface(Sprintf("bottom%g",i))={v[2]}; Physical Surface(Sprintf("top%g",i))={v[4]};
EndFor
EndIf
