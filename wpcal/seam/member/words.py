"""Words and numbers in names that tell what a solid is, in several languages, and what they are taken for.

Words are written as they are, and compared without case and accents. ``-schraube`` stands for every word that ends so,
``шайб-`` for every word that begins so. A phrase of several words is written with underscores.
"""

from __future__ import annotations

from enum import Enum

HEAD_FIRST = frozenset({"fr", "es", "it", "pt", "pl", "ru"})
"""Languages in which the noun comes before what describes it: *support de moteur* is a support."""


class Kind(Enum):
    """What a solid is taken for, in words."""

    FASTENER = "a bolt, screw, nut, washer, rivet, pin or nail"
    BEARING = "a bearing"
    GUIDE = "a linear guide or a ball screw"
    DRIVE = "a motor, a gearbox or a cylinder"
    SEAL = "a seal or a gasket"
    CABLE = "a cable, a hose, a belt or a chain"
    DEVICE = "an electric or optical device"
    SPRING = "a spring"
    WHEEL = "a tyre or a castor"
    WELD_NUT = "a nut or a stud to be welded"
    WOOD = "wood"
    PLASTIC = "plastic"
    RUBBER = "rubber"
    GLASS = "glass"
    SOFT = "foam, fabric or paper"
    STONE = "concrete or stone"
    STAINLESS = "stainless steel"
    STEEL = "steel"
    NICKEL = "a nickel alloy"
    ALUMINIUM = "aluminium"
    TITANIUM = "titanium"
    COPPER = "copper, brass or bronze"


NOT_METAL = frozenset({Kind.WOOD, Kind.PLASTIC, Kind.RUBBER, Kind.GLASS, Kind.SOFT, Kind.STONE})
METALS = frozenset({Kind.STAINLESS, Kind.STEEL, Kind.NICKEL, Kind.ALUMINIUM, Kind.TITANIUM, Kind.COPPER})
IRON = frozenset({Kind.STAINLESS, Kind.STEEL, Kind.NICKEL})
"""Metals that are welded to each other."""

WORDS: dict[Kind, dict[str, str]] = {
    Kind.WELD_NUT: {
        "en": "weld_nut weldnut weld_stud weld_bolt weld_screw weld_bung",
        "de": "schweissmutter -schweissmutter schweissbolzen schweissschraube anschweissmutter",
        "fr": "ecrou_a_souder goujon_soude", "es": "tuerca_soldable tuerca_para_soldar", "it": "dado_a_saldare",
        "zh": "焊接螺母 焊接螺柱",
    },
    Kind.FASTENER: {
        "en": "bolt screw nut washer rivet fastener nail capscrew setscrew grubscrew hexnut locknut nyloc circlip "
        "snap_ring retaining_ring cotter split_pin dowel_pin roll_pin spring_pin threaded_insert t_nut u_bolt "
        "lockwasher thumbscrew shcs bhcs fhcs",
        "de": "-schraube -schrauben -mutter -muttern unterlegscheibe unterlegscheiben -federscheibe -federring "
        "-zahnscheibe -facherscheibe u_scheibe niet -niet -nieten nagel -nagel sicherungsring sprengring splint "
        "-spannstift -zylinderstift -passstift -kerbstift gewindestift nutenstein gewindeeinsatz",
        "nl": "bout -bout moer -moer schroef -schroef sluitring borgring klinknagel spijker",
        "sv": "skruv -skruv mutter bricka -bricka nit spik",
        "fr": "vis ecrou rondelle boulon rivet clou goupille circlips goujon",
        "es": "tornillo tuerca arandela perno remache clavo pasador",
        "it": "vite dado rondella rosetta bullone rivetto chiodo spina copiglia",
        "pt": "parafuso porca arruela anilha rebite prego",
        "pl": "sruba wkret nakretka podkladka nit gwozdz zawleczka",
        "ru": "болт- винт винты гайк- шайб- заклепк- шуруп- саморез- шпильк- гвозд- шплинт-",
        "zh": "螺栓 螺钉 螺丝 螺母 螺帽 垫圈 垫片 铆钉 销钉 卡簧 挡圈 钉子",
        "ja": "ボルト ナット ワッシャ ねじ ネジ リベット 座金",
    },
    Kind.BEARING: {
        "en": "bearing bushing_igus rodend rod_end pillow_block ballbearing thrust_washer",
        "de": "-kugellager kugellager walzlager -walzlager gleitlager -gleitlager rollenlager nadellager "
        "-nadellager stehlager flanschlager gelenkkopf lager", "nl": "lager -lager", "fr": "roulement palier",
        "es": "rodamiento cojinete", "it": "cuscinetto", "pt": "rolamento mancal", "pl": "lozysko",
        "ru": "подшипник-", "zh": "轴承", "ja": "ベアリング 軸受",
    },
    Kind.GUIDE: {
        "en": "linear_rail linear_guide linear_bearing linear_slide ballscrew ball_screw leadscrew lead_screw "
        "slide_rail drawer_slide rail_carriage telescopic_rail",
        "de": "-fuhrungswagen linearfuhrung -linearfuhrung profilschiene kugelgewindetrieb linearwagen -teleskopschiene",
        "fr": "guidage_lineaire vis_a_billes", "es": "guia_lineal husillo", "it": "guida_lineare",
        "zh": "直线导轨 滑块 丝杠 滚珠丝杆", "ja": "リニアガイド リニアレール",
    },
    Kind.DRIVE: {
        "en": "motor gearmotor gearbox servo stepper actuator pump engine pneumatic_cylinder hydraulic_cylinder",
        "de": "-motor getriebe -getriebe pumpe -pumpe", "fr": "moteur reducteur verin pompe",
        "es": "motorreductor reductor bomba", "it": "motore riduttore pompa", "pt": "bomba_hidraulica",
        "pl": "silnik przekladnia", "ru": "двигател- мотор редуктор-", "zh": "电机 马达 减速机 气缸 油缸",
        "ja": "モータ シリンダ",
    },
    Kind.SEAL: {
        "en": "gasket o_ring oring seal grommet oilseal", "de": "dichtung -dichtung dichtring -dichtring o_ring",
        "fr": "joint_torique joint_plat", "es": "junta_torica empaquetadura", "it": "guarnizione",
        "pt": "vedacao", "pl": "uszczelka oring", "ru": "прокладк- уплотнени- сальник-", "zh": "密封圈 密封垫 油封",
        "ja": "ガスケット オーリング パッキン",
    },
    Kind.CABLE: {
        "en": "cable wire_rope hose timing_belt v_belt roller_chain wiring harness", "de": "kabel -kabel schlauch -schlauch "
        "riemen -riemen -kette", "fr": "courroie flexible_hydraulique chaine", "es": "manguera correa cadena",
        "it": "cavo cinghia catena", "pt": "mangueira correia corrente", "pl": "przewod pasek lancuch",
        "ru": "кабель шланг- ремень", "zh": "电缆 软管 皮带 链条", "ja": "ケーブル ホース ベルト",
    },
    Kind.DEVICE: {
        "en": "pcb sensor camera battery arduino raspberry_pi lcd led connector_plug switch encoder solenoid "
        "powersupply power_supply microcontroller relay potentiometer", "de": "-sensor leiterplatte -schalter batterie akku",
        "fr": "capteur batterie carte_electronique interrupteur", "es": "bateria placa_electronica interruptor",
        "it": "sensore batteria interruttore", "pl": "czujnik akumulator", "ru": "датчик- батаре- аккумулятор-",
        "zh": "传感器 电池 摄像头 电路板 开关", "ja": "センサ カメラ バッテリ 基板",
    },
    Kind.SPRING: {
        "en": "spring gas_spring torsion_spring", "de": "-feder druckfeder zugfeder gasfeder", "fr": "ressort",
        "es": "muelle resorte", "it": "molla", "pt": "mola", "pl": "sprezyna", "ru": "пружин-", "zh": "弹簧",
        "ja": "スプリング ばね",
    },
    Kind.WHEEL: {
        "en": "tire tyre caster castor caster_wheel castor_wheel", "de": "reifen lenkrolle bockrolle", "fr": "pneu roulette", "es": "neumatico",
        "it": "pneumatico", "pt": "pneu rodizio", "pl": "opona", "ru": "шина колесико", "zh": "轮胎 脚轮", "ja": "タイヤ キャスタ",
    },
    Kind.WOOD: {
        "en": "wood wooden plywood timber lumber mdf osb hardwood softwood chipboard fiberboard fibreboard hardboard "
        "particle_board oak pine spruce birch beech bamboo veneer balsa",
        "de": "-holz holz holz- sperrholz- spanplatte -spanplatte fichte buche eiche kiefer birke multiplexplatte siebdruckplatte",
        "nl": "-hout hout multiplex", "sv": "tra kryssfaner", "fr": "bois contreplaque sapin chene hetre",
        "es": "madera contrachapado pino roble", "it": "legno compensato multistrato", "pt": "madeira compensado",
        "pl": "drewno sklejka", "ru": "дерев- фанер- древесин-", "zh": "胶合板 木 竹", "ja": "合板 木材",
    },
    Kind.PLASTIC: {
        "en": "plastic nylon pom delrin acetal petg pvc cpvc upvc hdpe ldpe uhmw uhmwpe ptfe teflon polycarbonate polyamide "
        "polyethylene polypropylene acrylic plexiglass plexiglas perspex pmma peek polystyrene 3d_printed 3dprinted 3d_print "
        "pa6 pa66 pa12 grp gfrp fiberglass carbonfiber cfrp carbon_fiber igus",
        "de": "kunststoff -kunststoff kunststoff- plastik acrylglas gfk cfk", "fr": "plastique", "es": "plastico acrilico",
        "it": "plastica", "pt": "plastico", "pl": "tworzywo poliamid", "ru": "пластик- пластмасс- капролон фторопласт",
        "zh": "塑料 尼龙 亚克力", "ja": "プラスチック 樹脂 アクリル",
    },
    Kind.RUBBER: {
        "en": "rubber neoprene epdm nbr viton silicone elastomer polyurethane", "de": "gummi -gummi silikon elastomer",
        "fr": "caoutchouc", "es": "goma caucho", "it": "gomma", "pt": "borracha", "pl": "guma gumowy", "ru": "резин-",
        "zh": "橡胶 硅胶", "ja": "ゴム シリコン",
    },
    Kind.GLASS: {
        "en": "glass windscreen windshield", "de": "-glas glas", "fr": "verre vitre vitrage", "es": "vidrio cristal",
        "it": "vetro", "pt": "vidro", "pl": "szklo szyba", "ru": "стекло стекл-", "zh": "玻璃", "ja": "ガラス",
    },
    Kind.SOFT: {
        "en": "foam styrofoam felt fabric textile leather cork cardboard tarpaulin cushion upholstery",
        "de": "schaum -schaum schaumstoff filz stoffbezug leder pappe karton polster", "fr": "mousse feutre tissu cuir carton",
        "es": "espuma fieltro tela cuero carton", "it": "schiuma feltro tessuto", "pt": "espuma feltro tecido",
        "pl": "pianka filc tkanina", "ru": "пенопласт поролон войлок", "zh": "泡沫 海绵 皮革", "ja": "スポンジ フェルト",
    },
    Kind.STONE: {
        "en": "concrete cement brick masonry granite marble ceramic", "de": "beton -beton ziegel granit keramik", "fr": "brique granit",
        "es": "hormigon ladrillo", "it": "calcestruzzo mattone", "pt": "concreto tijolo", "pl": "cegla", "ru": "бетон- кирпич",
        "zh": "混凝土 砖 陶瓷", "ja": "コンクリート",
    },
    Kind.STAINLESS: {
        "en": "stainless 304 304l 316 316l 316ti 430 ss304 ss316 aisi304 aisi316 sus304 sus316 inox",
        "de": "edelstahl edelstahl- v2a v4a x5crni18 nirosta", "fr": "inoxydable", "es": "inoxidable", "it": "inossidabile",
        "pl": "nierdzewna nierdzewny", "ru": "нержавеющая нержавейка", "zh": "不锈钢", "ja": "ステンレス",
    },
    Kind.STEEL: {
        "en": "steel s235 s275 s355 s235jr s235j2 s275jr s355j2 s355jr s355j2g3 s355j0 s460 s690 q235 q345 q355 a36 a500 a513 a572 "
        "a992 a53 1018 1020 1045 4130 4140 ss400 st37 st52 dc01 dd11 c45 42crmo4 hardox weldox strenx",
        "de": "stahl -stahl stahl- baustahl", "nl": "staal", "sv": "stal", "fr": "acier", "es": "acero", "it": "acciaio", "pt": "aco",
        "pl": "stal", "ru": "сталь стальной", "zh": "钢 碳钢", "ja": "鋼 スチール",
    },
    Kind.NICKEL: {"en": "inconel hastelloy monel incoloy"},
    Kind.ALUMINIUM: {
        "en": "aluminium aluminum alum alu 6061 6063 6060 6082 5052 5083 5754 7075 2024 al6061 al6063 en_aw almg3 almgsi1",
        "fr": "dural", "es": "aluminio", "it": "alluminio", "ru": "алюмини-", "zh": "铝 铝合金", "ja": "アルミ",
    },
    Kind.TITANIUM: {"en": "titanium ti6al4v", "de": "titan", "fr": "titane", "es": "titanio", "zh": "钛", "ja": "チタン"},
    Kind.COPPER: {
        "en": "copper brass bronze", "de": "kupfer messing rotguss", "fr": "cuivre laiton", "es": "cobre laton bronce",
        "it": "rame ottone bronzo", "pl": "miedz mosiadz braz", "ru": "медь латунь бронза", "zh": "铜 黄铜", "ja": "銅 真鍮",
    },
}  # fmt: skip
"""Words by kind and language. Weld nuts come first: they are nuts, too."""

MATERIAL_ONLY: dict[Kind, str] = {
    Kind.PLASTIC: "abs pla pet pp pe pc pa ps pu asa tpe pei",
    Kind.RUBBER: "tpu nr sbr",
    Kind.STEEL: "mild carbon iron st_37 st_52 gjl gjs ggg gg25",
    Kind.ALUMINIUM: "al 1060 3003 2014 5086 7050",
}
"""Short words that tell something where a file says what the material is, and nothing in a name."""

STRUCTURE = (
    "plate bracket mount mounting holder housing support tube pipe beam gusset frame flange tab clevis channel angle "
    "profile post column stand base body block box cover lid panel arm lever bar sleeve seat adapter adaptor carrier tray "
    "duct guard hanger hook lug boss web rib stiffener brace strut foot leg cradle cage rack weldment cap clamp retainer "
    "yoke fork cross member crossmember spacer standoff stop table shelf wall hub pocket sheet strap guide "
    "platte -platte halter -halter halterung -halterung blech -blech rohr -rohr trager -trager winkel -winkel flansch "
    "-flansch rahmen -rahmen bock -bock konsole -konsole lasche -lasche steg rippe stutze gehause -gehause aufnahme "
    "-aufnahme deckel -deckel profil -profil buchse "
)
"""Nouns of steelwork. A *motor bracket* is a bracket: it is for a motor, and it may be welded."""
STRUCTURE_FIRST = (
    "plaque tole support equerre bride chassis cadre patte carter gousset platine socle "
    "placa soporte tubo escuadra brida bastidor marco chapa perfil viga carcasa base "
    "piastra supporto staffa flangia telaio lamiera profilo "
    "suporte estrutura plyta blacha wspornik rura kolnierz rama obudowa uchwyt "
    "пластин- плит- кронштейн- труб- фланец рам- лист- опор- стойк- корпус-"
)
"""The same in languages in which the noun comes first."""
STRUCTURE_ENDS = ("板", "座", "架", "管", "法兰", "壳", "盖", "梁", "台", "プレート", "ブラケット", "ホルダ")
"""The same at the end of Chinese and Japanese names."""
FOR_MATERIAL = frozenset(
    "connector anchor shoe bracket hanger burner stove saw screw heater splitter holder clamp support mount cutter press mold mould rack".split()
)
"""After a word for a material these say what it is for: a *wood connector* is steel."""

FASTENER_STANDARDS: dict[str, str] = {
    "din": "1 7 84 85 93 94 95 96 97 125 126 127 128 137 186 188 258 261 315 316 404 417 427 431 432 433 434 435 436 438 439 "
    "440 444 462 463 464 465 466 467 471 472 478 479 480 508 529 546 547 548 551 552 553 555 557 558 561 562 564 571 580 582 "
    "601 603 604 605 607 608 609 610 653 660 661 662 674 703 705 835 906 908 910 911 912 913 914 915 916 917 920 921 923 924 "
    "925 926 927 931 933 934 935 936 937 938 939 940 949 960 961 962 963 964 965 966 967 970 971 972 975 976 979 980 981 982 "
    "985 986 987 988 1052 1151 1440 1441 1443 1444 1471 1472 1473 1474 1475 1476 1477 1478 1479 1481 1587 1804 1816 6319 6325 "
    "6330 6331 6334 6340 6379 6796 6797 6798 6799 6885 6900 6901 6902 6903 6905 6908 6912 6914 6915 6916 6917 6918 6921 6923 "
    "6924 6925 6926 6927 7337 7338 7343 7344 7345 7346 7349 7500 7504 7513 7516 7603 7967 7968 7969 7971 7972 7973 7976 7977 "
    "7978 7979 7980 7981 7982 7983 7984 7985 7989 7990 7991 7992 7993 7995 7996 7997 7999 9021 11024 14399 28129",
    "iso": "1207 1234 1479 1481 1482 1483 1580 2009 2010 2338 2339 2340 2341 2342 4014 4015 4016 4017 4018 4026 4027 4028 4029 "
    "4032 4033 4034 4035 4036 4161 4162 4762 4766 4775 7040 7041 7042 7043 7044 7045 7046 7047 7048 7049 7050 7051 7089 7090 "
    "7091 7092 7093 7094 7379 7380 7411 7412 7413 7414 7415 7416 7417 7434 7435 7436 7437 7719 7720 8673 8674 8675 8676 8677 "
    "8733 8734 8735 8736 8737 8738 8739 8740 8741 8742 8743 8744 8745 8746 8747 8748 8750 8751 8752 8765 10509 10510 10511 "
    "10512 10513 10642 10644 10663 10669 10673 12125 12126 13337 14579 14580 14581 14583 14584 15071 15480 15481 15482 15483 "
    "15973 15974 15977 15978 15979 15980 15981 15982 15983 15984 16582 16583 16584",
    "en": "14399 15048 1661 1662 1663 1664 1665 1666 1667 14218 14219",
    "gb": "5780 5781 5782 5783 5785 5786 41 6170 6171 6172 6173 6174 6175 6176 6177 6182 6184 6185 6186 70 77 78 80 93 94 95 96 "
    "97 859 862 893 894 117 118 119 120 65 67 68 818 819 820 845 846 847 848 848 91 95 1228 1229 1230 3632 889 12",
    "jis": "1111 1115 1118 1122 1173 1174 1176 1177 1180 1181 1194 1213 1251 1252 1256 1351 1354 1355 1360",
    "uni": "5588 5589 5587 5737 5739 5725 5727 5731 5931 5933 6592 6593 7473 7474 1751 1734 6107 6609",
    "gost": "7798 7805 7808 5915 5916 5927 6958 6402 11371 10450 11738 1491 17473 17475 1144 1145 397 3128 3129",
    "pn": "82101 82105 82144 82153 82005 82302",
    "ansi": "18.2.1 18.2.2 18.3 18.6.3 18.21.1 18.22.1",
    "asme": "18.2.1 18.2.2 18.3 18.6.3 18.21.1 18.22.1",
}
"""Numbers of standards for bolts, screws, nuts, washers, rivets, pins, rings, keys and nails."""
WELD_NUT_STANDARDS: dict[str, str] = {"din": "928 929 977 32500 32501", "iso": "13918 21670"}
BEARING_STANDARDS: dict[str, str] = {
    "din": "615 616 618 625 628 630 635 711 715 720 722 728 5401 5412",
    "gb": "276 292 297",
}
SEAL_STANDARDS: dict[str, str] = {"din": "3760 3770 3771 7603 1514", "iso": "3601 6194"}

CODES: tuple[tuple[Kind, str], ...] = (
    (Kind.FASTENER, r"m(?:[2-9]|[1-3]\d|1\.6|2\.5)(?:x\d+(?:\.\d+)?){1,2}"),
    (
        Kind.BEARING,
        r"(?:6[0-3]\d|60\d\d|62\d\d|63\d\d|68\d\d|69\d\d|72\d\d|302\d\d|51[12]\d\d)(?:[ -]?(?:2rs1?|rs|zz|2z|llu|ddu))",
    ),
    (Kind.BEARING, r"(?:ucp|ucf|ucfl|ucfc|uct|kfl|kp|snl|lm|lmk|lmf)\d{1,3}(?:uu|luu)?"),
    (Kind.GUIDE, r"(?:hgr|hgh|hgw|mgn|mgw|egr|egh|sbr|tbr|lmr|sfu|hsr|ssr)\d{1,4}[a-z]{0,3}"),
    (Kind.DRIVE, r"nema ?\d{2}"),
)
"""What a designation without words tells: ``M8x30``, ``6204-2RS``, ``HGR15``, ``NEMA 17``."""
