#include <gtest/gtest.h>  // adelaide
