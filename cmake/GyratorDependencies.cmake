# What the library needs; shared by this build and by the installed package,
# so that a consumer's find_package(gyrator) looks for the same things.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(SUNDIALS 6.4 REQUIRED COMPONENTS cvode nvecserial sunmatrixdense sunlinsoldense sunnonlinsolfixedpoint)
find_package(Boost 1.74 REQUIRED)
find_package(NLopt REQUIRED)
find_package(muparser REQUIRED)
find_package(TBB 2021 REQUIRED)
find_package(OpenSSL 3.0 REQUIRED COMPONENTS Crypto)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
find_package(SerialHdf5 REQUIRED)
find_package(Libmodbus REQUIRED)
# Without it `study run` works on one machine only.
find_package(MPI COMPONENTS CXX)
