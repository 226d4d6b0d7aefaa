# Cross build for 64-bit ARM; what it builds runs under qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
# Debian's packages for the host satisfy find_package; what is built for ARM links none of them. The three
# libraries that it links are Debian's for ARM, installed beside the host's.
set(CMAKE_PREFIX_PATH /usr/lib/x86_64-linux-gnu/cmake)
set(hwy_DIR /usr/lib/aarch64-linux-gnu/cmake/hwy)
set(TBB_DIR /usr/lib/aarch64-linux-gnu/cmake/TBB)
set(zstd_DIR /usr/lib/aarch64-linux-gnu/cmake/zstd)
