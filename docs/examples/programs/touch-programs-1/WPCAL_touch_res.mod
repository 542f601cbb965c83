MODULE WPCAL_touch_res
  ! results of WPCAL_touch; the program writes them, and saves this module
  PERS string wptPlan:="";
  PERS string wptTool:="tTorch";
  PERS num wptCount:=2;
  PERS wobjdata wptPart:=[FALSE,TRUE,"",[[812.00000,-240.00000,156.00000],[0.955090735,0.014722824,-0.013761999,0.295627355]],[[0,0,0],[1,0,0,0]]];
  PERS num wptO_T1:=0;
  PERS robtarget wptP_T1:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  PERS num wptO_T4:=0;
  PERS robtarget wptP_T4:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
ENDMODULE
