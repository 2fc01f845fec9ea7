#!/bin/sh
# Ends as it is told to.
case $1 in
  hang) while :; do :; done ;;
  silent) poweroff -f ;;
  *) exit "$1" ;;
esac
