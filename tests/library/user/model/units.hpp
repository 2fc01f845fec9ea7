#pragma once
// The user's own, of the same name as one of smaservo's.

inline constexpr double users_ambient_K = 298.15;
