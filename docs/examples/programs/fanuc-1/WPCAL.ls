/PROG  WPCAL
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 87;
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
  28:  !weld speed <= 8 mm/s ;
  29:  !air speed <= 100 mm/s ;
  30:  !DRY RUN: the arc stays off, ARC ;
  31:  !  ON and ARC OFF are comments ;
  32:  !  (--arc on makes them ;
  33:  !  instructions) ;
  34:  !checked against the part, to ;
  35:  !  0.05 mm: a straight torch of ;
  36:  !  300 mm, nozzle radius 11 mm, ;
  37:  !  wire 20 mm ;
  38:  !between seams the tool goes 61 ;
  39:  !  mm above the part, 3 mm from ;
  40:  !  it at least ;
  41:  !NOT CHECKED: the arm, fixtures, ;
  42:  !  cables, the way to the first ;
  43:  !  point. RUN IT DRY FIRST ;
  44:  !sets UFRAME 4 to the part: ;
  45:  ! X 812.498 ;
  46:  ! Y -240.211 ;
  47:  ! Z 155.805 ;
  48:  ! W 1.095 ;
  49:  ! P -2.025 ;
  50:  ! R 34.340 ;
  51:  !points are relative to it, mm ;
  52:  !R = Rz(R) Ry(P) Rx(W), deg ;
  53:  !rounded within 0.001 mm, 0.001 ;
  54:  !  deg ;
  55:  !by PR[51], which it overwrites ;
  56:  !CONFIG as given by the user ;
  57:  !seam -> program here ;
  58:  ! W1 -> W1: tee fillet, 8.0 mm, 1 ;
  59:  !  line, 95 % error up to 0.227 ;
  60:  !  mm ;
  61:  ! W2 -> W2: tee fillet, 150.0 mm, ;
  62:  !  1 line, 95 % error up to 0.265 ;
  63:  !  mm ;
  64:  ! W3 -> W3: tee fillet, 150.0 mm, ;
  65:  !  1 line, 95 % error up to 0.259 ;
  66:  !  mm ;
  67:  ! W4 -> W4: tee fillet, 8.0 mm, 1 ;
  68:  !  line, 95 % error up to 0.265 ;
  69:  !  mm ;
  70:  UTOOL_NUM=2 ;
  71:  PR[51]=LPOS ;
  72:  PR[51,1]=812.498 ;
  73:  PR[51,2]=(-240.211) ;
  74:  PR[51,3]=155.805 ;
  75:  PR[51,4]=1.095 ;
  76:  PR[51,5]=(-2.025) ;
  77:  PR[51,6]=34.340 ;
  78:  UFRAME[4]=PR[51] ;
  79:  UFRAME_NUM=4 ;
  80:J P[1] 10% FINE ;
  81:  CALL W1 ;
  82:  CALL W2 ;
  83:  CALL W3 ;
  84:  CALL W4 ;
  85:  UFRAME_NUM=4 ;
  86:  UTOOL_NUM=2 ;
  87:L P[1] 100mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   105.254  mm,	Y =    62.839  mm,	Z =   153.538  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
