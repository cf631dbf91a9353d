// What Asio and Beast compile once where BOOST_ASIO_SEPARATE_COMPILATION and
// BOOST_BEAST_SEPARATE_COMPILATION are defined (cmake/targets.cmake), instead of in every file that
// uses them.
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
