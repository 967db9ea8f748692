#pragma once
/// \file
/// The compiled part of jpeg_file.hpp: libjpeg-turbo, if TAPESTRY_JPEG is defined, so that the program links
/// it.
#include <tapestry/io/jpeg_file.hpp>
#if defined(TAPESTRY_JPEG)
#include <turbojpeg.h>
#include <memory>
#endif

namespace tapestry::io::detail {
#if defined(TAPESTRY_JPEG)
JpegComplaint decode_jpeg(std::string_view file, const JpegHeader& header, bool is_strict,
                          std::uint8_t* pixels) {
  const auto close = [](void* decoder) { tjDestroy(decoder); };
  const std::unique_ptr<void, decltype(close)> decoder(tjInitDecompress(), close);
  if (decoder == nullptr) return {"no memory for its decoder"};
  // A cut or damaged picture is only a warning to the library, which fills missing parts with grey.
  const int flags = TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS | (is_strict ? TJFLAG_STOPONWARNING : 0);
  const int status =
      tjDecompress2(decoder.get(), reinterpret_cast<const unsigned char*>(file.data()),
                    static_cast<unsigned long>(file.size()), pixels, static_cast<int>(header.width), 0,
                    static_cast<int>(header.height), header.channels == 4 ? TJPF_CMYK : TJPF_RGB, flags);
  if (status == 0) return {};
  return {tjGetErrorStr2(decoder.get()), tjGetErrorCode(decoder.get()) == TJERR_WARNING};
}
#else
JpegComplaint decode_jpeg(std::string_view, const JpegHeader&, bool, std::uint8_t*) {
  return {"built without libjpeg-turbo"};
}
#endif
}  // namespace tapestry::io::detail
