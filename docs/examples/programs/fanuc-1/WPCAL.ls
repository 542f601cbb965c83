/PROG  WPCAL
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 85;
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,*,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
   1:  !written by wpcal 0.1.1 from ;
   2:  !  calibration.json and ;
   3:  !  seams.json ;
   4:  !calibration PASS, tolerance 0.5 ;
   5:  !  mm ;
   6:  !the 4 accepted seams are within ;
   7:  !  0.284 mm with 95 % confidence ;
   8:  !  (teaching error 0.094 mm per ;
   9:  !  axis, estimated from the ;
  10:  !  residuals with 6 degrees of ;
  11:  !  freedom, robot 0.25 mm per ;
  12:  !  axis over 686 mm, assumed: ;
  13:  !  uncalibrated six-axis arm), ;
  14:  !  the tolerance is 0.5 mm ;
  15:  !wire leaves the tip along +z of ;
  16:  !  the tool, z_sense inward ;
  17:  !work angle 0 deg, travel 0 deg ;
  18:  !  (+ push) ;
  19:  !turn about the wire: as few ;
  20:  !  moves need it, within 180 deg ;
  21:  !  of the travel direction ;
  22:  !tool centre point 0 mm back from ;
  23:  !  the tip, approach 50 mm, ;
  24:  !  retract 50 mm ;
  25:  !lines and arcs: the wire is at ;
  26:  !  most 0.000 mm and 0.00 deg off ;
  27:  !  (allowed: 0.05 mm, 0.5 deg) ;
  28:  !DRY RUN: the arc stays off, ARC ;
  29:  !  ON and ARC OFF are comments ;
  30:  !  (--arc on makes them ;
  31:  !  instructions) ;
  32:  !checked against the part, to ;
  33:  !  0.05 mm: a straight torch of ;
  34:  !  300 mm, nozzle radius 11 mm, ;
  35:  !  wire 20 mm ;
  36:  !between seams the tool goes 61 ;
  37:  !  mm above the part, 3 mm from ;
  38:  !  it at least ;
  39:  !NOT CHECKED: the arm, fixtures, ;
  40:  !  cables, the way to the first ;
  41:  !  point. RUN IT DRY FIRST ;
  42:  !sets UFRAME 4 to the part: ;
  43:  ! X 812.498 ;
  44:  ! Y -240.211 ;
  45:  ! Z 155.805 ;
  46:  ! W 1.095 ;
  47:  ! P -2.025 ;
  48:  ! R 34.340 ;
  49:  !points are relative to it, mm ;
  50:  !R = Rz(R) Ry(P) Rx(W), deg ;
  51:  !rounded within 0.001 mm, 0.001 ;
  52:  !  deg ;
  53:  !by PR[51], which it overwrites ;
  54:  !CONFIG as given by the user ;
  55:  !seam -> program here ;
  56:  ! W1 -> W1: tee fillet, 8.0 mm, 1 ;
  57:  !  line, 95 % error up to 0.227 ;
  58:  !  mm ;
  59:  ! W2 -> W2: tee fillet, 150.0 mm, ;
  60:  !  1 line, 95 % error up to 0.265 ;
  61:  !  mm ;
  62:  ! W3 -> W3: tee fillet, 150.0 mm, ;
  63:  !  1 line, 95 % error up to 0.259 ;
  64:  !  mm ;
  65:  ! W4 -> W4: tee fillet, 8.0 mm, 1 ;
  66:  !  line, 95 % error up to 0.265 ;
  67:  !  mm ;
  68:  UTOOL_NUM=2 ;
  69:  PR[51]=LPOS ;
  70:  PR[51,1]=812.498 ;
  71:  PR[51,2]=(-240.211) ;
  72:  PR[51,3]=155.805 ;
  73:  PR[51,4]=1.095 ;
  74:  PR[51,5]=(-2.025) ;
  75:  PR[51,6]=34.340 ;
  76:  UFRAME[4]=PR[51] ;
  77:  UFRAME_NUM=4 ;
  78:J P[1] 10% FINE ;
  79:  CALL W1 ;
  80:  CALL W2 ;
  81:  CALL W3 ;
  82:  CALL W4 ;
  83:  UFRAME_NUM=4 ;
  84:  UTOOL_NUM=2 ;
  85:L P[1] 100mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   105.254  mm,	Y =    62.839  mm,	Z =   153.538  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
