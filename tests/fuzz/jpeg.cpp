#ifdef TAPESTRY_JPEG
#include <turbojpeg.h>

#include <tapestry/io/jpeg_file.hpp>

#include "target.hpp"

namespace {
using namespace tapestry;

void read(const std::string& bytes) { (void)io::parse_jpeg(bytes, "a.jpg"); }

std::vector<std::string> seeds() {
  std::vector<unsigned char> pixels;
  for (std::size_t i = 0; i < 19 * 11 * 3; ++i) pixels.push_back(static_cast<unsigned char>(i * i));
  std::vector<std::string> files;
  const tjhandle encoder = tjInitCompress();
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    for (const int sampling : {TJSAMP_444, TJSAMP_420, TJSAMP_GRAY}) {
      unsigned char* bytes = nullptr;
      unsigned long size = 0;
      if (tjCompress2(encoder, pixels.data(), 19, 0, 11, TJPF_RGB, &bytes, &size, sampling, 70, flags) == 0)
        files.emplace_back(reinterpret_cast<const char*>(bytes), size);
      tjFree(bytes);
    }
  }
  tjDestroy(encoder);
  return files;
}

const fuzz::Registered target({"jpeg", read, seeds});
}  // namespace
#endif
