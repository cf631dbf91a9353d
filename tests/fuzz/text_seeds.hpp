#pragma once

#include <array>

namespace infuse::fuzz {

/// A short sound input of one fuzzer.
struct TextSeed {
  const char* fuzzer;
  const char* name;
  const char* text;
};

inline constexpr std::array kTextSeeds = {
    TextSeed{"candump_fuzz", "frames",
             "(1700000000.000001) can0 123#0102030405060708\n"
             "(1700000000.010000) can0 18FEF100#FF\n(1700000000.02) vcan1 7FF#R\n"
             "(1700000000.030000) can0 123##1AABBCC\n"},
    TextSeed{"csv_fuzz", "gnss",
             "0stamp_ns,latitude_deg,longitude_deg,altitude,speed,course_deg,hdop,utc_ns,valid\n"
             "1700000000000000000,49.01,8.4,110,10,90,0.8,1700000000000000000,1\n"
             "1700000000100000000,49.02,8.4,,,,,0,0\n"},
    TextSeed{"csv_fuzz", "imu",
             "1stamp_ns,wx,wy,wz,ax,ay,az\n1700000000000000000,0,0,0.1,0,0,9.81\nx,,\n"},
    TextSeed{"csv_fuzz", "speed", "2stamp_ns,speed\n1700000000000000000,12.5\n1,nan\n"},
    TextSeed{"csv_fuzz", "times",
             "3stamp_ns,end_ns,exposure_ns,source\n1700000000000000000,1700000000100000000,,a.bin\n"
             "1700000000100000000,,1700000000150000000,\"b,c\"\n17"},
    TextSeed{"dbc_fuzz", "signals",
             "VERSION \"1\"\nNS_ :\n  CM_\nBS_:\nBU_: ECU\nBO_ 256 WHEELS: 8 ECU\n"
             " SG_ FL : 7|16@0+ (0.01,0) [0|655] \"m/s\" ECU\n"
             " SG_ FR : 16|12@1- (0.5,-10) [0|0] \"\" ECU,XXX\n"
             "BO_ 2566834709 EXTENDED: 8 ECU\n SG_ S M : 0|4@1+ (1,0) [0|15] \"\" ECU\n"
             " SG_ A m0 : 8|8@1+ (1,0) [0|255] \"\" ECU\nCM_ SG_ 256 FL \"two\nlines\";\n"
             "VAL_ 256 FR -1 \"minus one\" 3 \"three\" ;\nSIG_VALTYPE_ 256 FL : 1;\n"},
    TextSeed{"folder_toml_fuzz", "description",
             "0[[lidar]]\nname = \"t\"\npackets = \"t.pcap\"\n"
             "T_vehicle_lidar = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1]\n"
             "[[camera]]\nname = \"c\"\nimages = \"p\"\nwidth = 64\nheight = 48\nfx = 50\nfy = 50\n"
             "cx = 32\ncy = 24\nlidar = \"t\"\n"
             "T_camera_lidar = [0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1]\n"
             "stamps = { rate_hz = 10, start = \"2018-08-02 16:14:48.25\", offset_s = 1 }\n"},
    TextSeed{"folder_toml_fuzz", "table",
             "1# c\ntime,file\n1700000600.1,a/b.png\n2018-08-02 16:14:48.25,\"c.png\"\n"},
    TextSeed{"g2o_fuzz", "planar",
             "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.5 1.5\nFIX 0\n"
             "EDGE_SE2 0 1 1 0.25 1.5 10 1 0 20 0 300\n"},
    TextSeed{"g2o_fuzz", "spatial",
             "# one edge\n"
             "EDGE_SE3:QUAT 7 2 1 2 3 0 0 -0.6 -0.8 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0.5 6\n"},
    TextSeed{"kitti_text_fuzz", "calibration",
             "0P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP2: 700 0 600 45 0 700 180 0.2 0 0 1 0.003\n"
             "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n"},
    TextSeed{"kitti_text_fuzz", "stamps",
             "12011-09-26 13:02:25.964389445\n\n2011-09-26 13:02:26.067655000\n1.0e+00\n"},
    TextSeed{"kitti_text_fuzz", "numbers",
             "21 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30\n"},
    TextSeed{"nmea_fuzz", "rmc",
             "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n"},
    TextSeed{"nmea_fuzz", "gga",
             "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"},
    TextSeed{
        "osm_fuzz", "xml",
        "0<osm version=\"0.6\"><bounds minlat=\"49\" minlon=\"8\" maxlat=\"49.1\" "
        "maxlon=\"8.1\"/><node id=\"1\" lat=\"49\" lon=\"8\"/><node id=\"2\" lat=\"49.001\" "
        "lon=\"8\"><tag k=\"a\" v=\"b\"/></node><node id=\"3\" lat=\"49\" lon=\"8.001\"/>"
        "<way id=\"4\"><nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"residential\"/>"
        "<tag k=\"width\" v=\"20'\"/></way><way id=\"5\"><nd ref=\"1\"/><nd ref=\"2\"/>"
        "<nd ref=\"3\"/><nd ref=\"1\"/><tag k=\"building\" v=\"yes\"/></way>"
        "<relation id=\"6\"><member type=\"way\" ref=\"5\" role=\"outer\"/>"
        "<tag k=\"type\" v=\"multipolygon\"/><tag k=\"landuse\" v=\"forest\"/></relation></osm>"},
    TextSeed{"pcd_fuzz", "ascii",
             "FIELDS x y z intensity ring\nSIZE 4 4 4 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\n"
             "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3 9 0\n"
             "nan nan nan 0 1\n"},
    TextSeed{"ply_fuzz", "ascii",
             "ply\nformat ascii 1.0\ncomment c\nelement vertex 2\nproperty float x\n"
             "property float y\nproperty float z\nproperty uchar intensity\nproperty ushort ring\n"
             "element face 0\nproperty list uchar int vertex_indices\nend_header\n1 2 3 9 0\n"
             "4 5 6 8 1\n"},
    TextSeed{"ply_fuzz", "binary",
             "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
             "property float y\nproperty float z\nend_header\nabcdefghijkl"},
    TextSeed{"request_fuzz", "poll", "{\"op\":\"poll\"}"},
    TextSeed{
        "request_fuzz", "watch",
        "{\"op\":\"watch\",\"classes\":[\"POSE\",\"HEALTH\"],\"max_hz\":5,\"device\":\"top\"}"},
    TextSeed{"request_fuzz", "record",
             "{\"op\":\"record\",\"name\":\"a\",\"duration_s\":5,\"max_bytes\":1000000}"},
    TextSeed{"request_fuzz", "freeze", "{\"op\":\"freeze\",\"device\":\"front\",\"on\":true}"},
    TextSeed{"trajectory_fuzz", "tum",
             "# a\n1700000000.5 1 2 3 0 0 0 1\n1700000001 1 2 3 0 0 1 0\n"},
    TextSeed{"trajectory_fuzz", "kitti", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n"},
    TextSeed{
        "drive_entry_fuzz", "entry",
        R"({"form":1,"vehicle":"car","drive":"monday","failures":[{"step":"replay","what":"damaged")"
        R"(}],"calibrations":[{"camera":"front","lidar":"top","usable":true,"reason":"","T_camera_l)"
        R"(idar":[0,-1,0,0.1,0,0,-1,-0.3,1,0,0,-0.5,0,0,0,1],"covariance":[[9.8e-07,0,0,0,0,0],[0,9)"
        R"(.8e-07,0,0,0,0],[0,0,9.8e-07,0,0,0],[0,0,0,5e-05,0,0],[0,0,0,0,5e-05,0],[0,0,0,0,0,5e-05)"
        R"(]],"covariance_of_scenes":[[4.9e-07,0,0,0,0,0],[0,4.9e-07,0,0,0,0],[0,0,4.9e-07,0,0,0],[)"
        R"(0,0,0,2.5e-05,0,0],[0,0,0,0,2.5e-05,0],[0,0,0,0,0,2.5e-05]],"covariance_of_motion":[[0,0)"
        R"(,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0]]}],"repl)"
        R"(ay":{"drive_s":12.5,"alerts":2},"stamp":1772352000000000000})"},
};

}  // namespace infuse::fuzz
