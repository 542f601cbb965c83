MODULE Teach
  ! corners of the plate; P3 was never taught
  PERS wobjdata wPart:=[FALSE,TRUE,"",[[800.5,-20,300],[1,0,0,0]],[[0,0,0],[0.7071068,0,0,0.7071068]]];
  CONST robtarget V1:=[[12.5,-3,0.25],[0,1,0,0],[0,-1,0,1],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget V2:=[[1E2,-.5,+7.],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget P3:=[[0,0,0],[0,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR robtarget row{2}:=[[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],[[4,5,6],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
  CONST jointtarget J1:=[[10,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL V1,v100,fine,tTorch\WObj:=wPart;
    MoveL Offs(V2,0,0,10),v100,z1,tool0;
    MoveJ row{1},v100,fine,tTorch\WObj:=wobj0;
    TPWrite "a string with ; and ! in it";
  ENDPROC
ENDMODULE
