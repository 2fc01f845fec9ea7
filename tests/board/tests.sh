#!/bin/sh
# The tests of board_tests whose names begin so.
exec /board_tests --gtest_brief=1 --gtest_filter="$1*"
