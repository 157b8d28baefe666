"""Package for Spack. SPDX-License-Identifier: BSD-3-Clause"""
import os

from spack.package import *


class Libmbsrank(CMakePackage):
    """O(N) dynamics of multibody systems with massless bodies."""

    license("BSD-3-Clause")
    version("0.1.0", url=os.environ.get("MBSRANK_URL"), sha256=os.environ.get("MBSRANK_SHA256"))

    variant("ida", default=True, description="Runs by SUNDIALS IDA")
    variant("files", default=True, description="Models from files, and the program mbsrank")
    variant("fe", default=True, description="Flexible bodies from finite elements")
    variant("shared", default=True, description="Shared libraries")

    depends_on("c", type="build")
    depends_on("cmake@3.21:", type="build")
    depends_on("blas")
    depends_on("lapack")
    depends_on("sundials@6.4:", when="+ida")
    depends_on("expat", when="+files")
    depends_on("hdf5~mpi", when="+files")
    depends_on("libpng", when="+files")
    depends_on("zlib-api", when="+files")
    depends_on("suite-sparse", when="+fe")

    def cmake_args(self):
        return [
            self.define_from_variant("MBSR_IDA", "ida"),
            self.define_from_variant("MBSR_FILES", "files"),
            self.define_from_variant("MBSR_FE", "fe"),
            self.define_from_variant("BUILD_SHARED_LIBS", "shared"),
            self.define("MBSR_TESTS", False),
            self.define("MBSR_EXAMPLES", False),
            self.define("MBSR_VIEWER", "OFF"),
        ]
