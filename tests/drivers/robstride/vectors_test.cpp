// That a wrong RobStride vector would be noticed; the right ones are held in vectors/.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/drivers/robstride/vectors.hpp"

namespace geodesic::drivers::test {
namespace {

std::size_t problems(const std::string& row) {
  std::istringstream stream("direction,description,can_id,is_extended,is_fd,data,values\n" + row);
  return check_robstride_row(read_rows(stream, "brought.csv").front()).size();
}

TEST(RobstrideVectors, AWrongOneIsNoticed) {
  const std::string ranges = "pmax=12.5;vmax=30.0;kpmax=500.0;kdmax=5.0;tmax=12.0\n";
  const std::string command =
      ",1,0,747A7EB63136D4A1,motor_id=127;p_des=-1.125;v_des=-0.301;kp=96.12;kd=4.153;t_ff=-9.85;";
  EXPECT_EQ(problems("command,right,0116EE7F" + command + ranges), 0U);
  EXPECT_NE(problems("command,torque,0118EE7F" + command + ranges), 0U);
  EXPECT_NE(problems("command,motor,0116EE7E" + command + ranges), 0U);
  EXPECT_NE(problems("command,type,0216EE7F" + command + ranges), 0U);
  EXPECT_NE(problems("command,scaling,0116EE7F" + command +
                     "pmax=12.5;vmax=30.0;kpmax=500.0;kdmax=5.0;tmax=17.0\n"),
            0U);
  const std::string state =
      ",motor_id=127;mode=2;fault_bits=0;position=-0.874914169;velocity=2.06591797;"
      "torque=10.7588921;temperature=57.1;pmax=12.5;vmax=30.0;tmax=12.0\n";
  EXPECT_EQ(problems("feedback,right,02807FFD,1,0,770A88D0F2C2023B" + state), 0U);
  for (const char* wrong : {"02817FFD,1,0,770A88D0F2C2023B", "02407FFD,1,0,770A88D0F2C2023B",
                            "02807EFD,1,0,770A88D0F2C2023B", "02807FFD,1,0,0A7788D0F2C2023B",
                            "02807FFD,1,0,770A88D1F2C2023B", "02807FFD,1,0,770A88D0F2C1023B",
                            "02807FFD,1,0,770A88D0F2C2023C"}) {
    EXPECT_NE(problems(std::string("feedback,wrong,").append(wrong).append(state)), 0U) << wrong;
  }
  const std::string read = ",type=17;motor_id=1;index=28697;";
  EXPECT_EQ(problems("feedback,ok,110001FD,1,0,197000000000A0BF" + read + "status=0;value=-1.25\n"),
            0U);
  EXPECT_NE(
      problems("feedback,status,110101FD,1,0,197000000000A0BF" + read + "status=0;value=-1.25\n"),
      0U);
  EXPECT_EQ(problems("command,NaN: our encoder must refuse,0100007F,1,0,0000000000000000,"
                     "motor_id=127;p_des=0;v_des=0;kp=0;kd=0;t_ff=nan;" +
                     ranges),
            0U);
}

}  // namespace
}  // namespace geodesic::drivers::test
