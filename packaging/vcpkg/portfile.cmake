# Port for vcpkg. SPDX-License-Identifier: BSD-3-Clause
vcpkg_download_distfile(archive URLS "$ENV{MBSRANK_URL}" FILENAME "libmbsrank-${VERSION}.tar.xz" SHA512 "$ENV{MBSRANK_SHA512}")
vcpkg_extract_source_archive(source ARCHIVE "${archive}")
vcpkg_check_features(OUT_FEATURE_OPTIONS features FEATURES ida MBSR_IDA files MBSR_FILES fe MBSR_FE)
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" dynamic shared)
vcpkg_cmake_configure(SOURCE_PATH "${source}" OPTIONS ${features} -DBUILD_SHARED_LIBS=${shared} -DMBSR_TESTS=OFF
                      -DMBSR_EXAMPLES=OFF -DMBSR_PROGRAM=OFF -DMBSR_FMU=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME mbsrank CONFIG_PATH lib/cmake/mbsrank)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${source}/LICENSE")
