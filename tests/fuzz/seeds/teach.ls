/PROG  TEACH
/ATTR
COMMENT = "corners";
/MN
   1:  UFRAME_NUM=1 ;
   2:L P[1] 100mm/sec FINE    ;
/POS
P[1:"V1"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   812.300  mm,	Y =    -4.250  mm,	Z =   100.000  mm,
	W =   180.000 deg,	P =      .000 deg,	R =   -90.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 0,
	J1=    10.000 deg,	J2=    20.000 deg,	J3=   -30.000 deg,
	J4=     0.000 deg,	J5=   -90.000 deg,	J6=     0.000 deg
   GP2:
	UF : 0, UT : 1,
	J1=    10.000 deg
};
P[3:"never"]{
   GP1:
	UF : F, UT : F,		CONFIG : 'N U T, 0, 0, 0',
	X =  ********  mm,	Y =  ********  mm,	Z =  ********  mm,
	W =  ******** deg,	P =  ******** deg,	R =  ******** deg
};
/END
