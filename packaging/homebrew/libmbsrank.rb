# Formula for Homebrew. SPDX-License-Identifier: BSD-3-Clause
class Libmbsrank < Formula
  desc "O(N) dynamics of multibody systems with massless bodies"
  url ENV.fetch("HOMEBREW_MBSRANK_URL")
  version "0.1.0"
  sha256 ENV.fetch("HOMEBREW_MBSRANK_SHA256")
  license "BSD-3-Clause"

  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "expat"
  depends_on "hdf5"
  depends_on "libpng"
  depends_on "openblas"
  depends_on "suite-sparse"
  depends_on "sundials"

  def install
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", *std_cmake_args, "-DBLA_VENDOR=OpenBLAS",
           "-DMBSR_TESTS=OFF", "-DMBSR_EXAMPLES=OFF", "-DMBSR_VIEWER=OFF"
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    (testpath/"version.c").write <<~C
      #include <mbsrank/mbsrank.h>
      int main(void) { return mbsr_version()[0] == 0; }
    C
    system ENV.cc, "version.c", "-I#{include}", "-L#{lib}", "-lmbsrank", "-o", "version"
    system "./version"
  end
end
