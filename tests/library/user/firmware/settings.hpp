#pragma once
// The user's own, of the same name as one of smaservo's.

inline constexpr double users_stress_Pa = 150e6;
