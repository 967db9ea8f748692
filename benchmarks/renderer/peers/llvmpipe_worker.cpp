// The car as Mesa's llvmpipe draws it, in memory through OSMesa.
#define GL_GLEXT_PROTOTYPES  // for the types of the functions that OSMesa hands out
#include <GL/osmesa.h>

#include <map>

#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
/// An OpenGL function by its name.
template <class Function>
[[nodiscard]] Function gl(const char* name) {
  const auto function = reinterpret_cast<Function>(OSMesaGetProcAddress(name));
  if (function == nullptr) throw Error(ErrorKind::usage, std::string("llvmpipe has no ") + name);
  return function;
}
#define GL_CALL(name) gl<decltype(&::name)>(#name)

constexpr const char* vertex_program = R"(#version 330
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 corner_uv;
uniform mat4 clip_from_world;
out vec2 uv;
void main() { uv = corner_uv; gl_Position = clip_from_world * vec4(position, 1); })";
constexpr const char* face_program = R"(#version 330
out ivec4 face;
void main() { face = ivec4(gl_PrimitiveID, 0, 0, 0); })";
constexpr const char* paint_program = R"(#version 330
in vec2 uv;
uniform sampler2D paint;
out vec4 colour;
void main() { colour = vec4(texture(paint, uv).rgb, 1); })";

/// clip_from_world of a camera, column-major, with the picture's first row at the bottom of OpenGL's.
[[nodiscard]] std::array<float, 16> clip_from_world(const geometry::Camera& camera) {
  const double n = camera.near, f = camera.far;
  const std::array<double, 3> scale{1 / camera.tan_half_fov_x, 1 / camera.tan_half_fov_y, (f + n) / (f - n)};
  std::array<float, 16> matrix{};
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<double, 3> view{};
    for (std::size_t i = 0; i < 3; ++i) view[i] = k < 3 ? camera.rotation[i][k] : camera.translation[i];
    for (std::size_t i = 0; i < 3; ++i) matrix[4 * k + i] = static_cast<float>(view[i] * scale[i]);
    matrix[4 * k + 3] = static_cast<float>(view[2]);
    if (k == 3) matrix[14] = static_cast<float>(view[2] * scale[2] - 2 * f * n / (f - n));
  }
  return matrix;
}

class LlvmpipeRenderer {
 public:
  LlvmpipeRenderer(const Scene& scene, const WorkerOptions& options)
      : scene_(scene), size_(static_cast<int>(options.size)), finds_faces_(options.stage == "visibility") {
    if (!finds_faces_ && options.stage != "frame")
      throw Error(ErrorKind::usage, "llvmpipe finds faces and draws frames only");
    const std::string threads = options.threads == 1 ? "0" : std::to_string(options.threads);
    ::setenv("LP_NUM_THREADS", threads.c_str(), 1);  // 0: none beside the caller
    ::setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    make_context();
    make_target();
    upload_mesh();
    make_program();
    if (!finds_faces_) upload_texture();
    GL_CALL(glEnable)(GL_DEPTH_TEST);
    GL_CALL(glViewport)(0, 0, size_, size_);
  }
  LlvmpipeRenderer(const LlvmpipeRenderer&) = delete;
  LlvmpipeRenderer& operator=(const LlvmpipeRenderer&) = delete;
  ~LlvmpipeRenderer() { OSMesaDestroyContext(context_); }

  [[nodiscard]] std::string name() const {
    return std::string("llvmpipe, ") + reinterpret_cast<const char*>(GL_CALL(glGetString)(GL_VERSION));
  }

  void run() {
    for (const geometry::Camera& camera : scene_.cameras) draw(camera);
  }

  [[nodiscard]] std::vector<float> answer() {
    draw(scene_.cameras.front());
    const auto read = GL_CALL(glReadPixels);
    const std::size_t count = static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_);
    if (finds_faces_) {
      std::vector<std::int32_t> face(count);
      read(0, 0, size_, size_, GL_RED_INTEGER, GL_INT, face.data());
      return {face.begin(), face.end()};
    }
    std::vector<float> picture(3 * count);
    read(0, 0, size_, size_, GL_RGB, GL_FLOAT, picture.data());
    return picture;
  }

 private:
  void make_context() {
    const std::array<int, 11> wanted{OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 0, OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE, OSMESA_CONTEXT_MAJOR_VERSION, 3,
                                     OSMESA_CONTEXT_MINOR_VERSION, 3,
                                     // The end.
                                     0};
    context_ = OSMesaCreateContextAttribs(wanted.data(), nullptr);
    window_.resize(64);
    if (context_ == nullptr ||
        OSMesaMakeCurrent(context_, window_.data(), GL_UNSIGNED_BYTE, 4, 4) == GL_FALSE)
      throw Error(ErrorKind::usage, "OSMesa gives no context of OpenGL 3.3");
  }

  /// The picture: one integer a pixel, or four bytes, and depth.
  void make_target() {
    std::array<GLuint, 3> names{};
    GL_CALL(glGenFramebuffers)(1, &names[0]);
    GL_CALL(glBindFramebuffer)(GL_FRAMEBUFFER, names[0]);
    GL_CALL(glGenRenderbuffers)(2, &names[1]);
    const auto attach = [&](GLuint name, GLenum format, GLenum point) {
      GL_CALL(glBindRenderbuffer)(GL_RENDERBUFFER, name);
      GL_CALL(glRenderbufferStorage)(GL_RENDERBUFFER, format, size_, size_);
      GL_CALL(glFramebufferRenderbuffer)(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, name);
    };
    attach(names[1], finds_faces_ ? GL_R32I : GL_RGBA8, GL_COLOR_ATTACHMENT0);
    attach(names[2], GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    if (GL_CALL(glCheckFramebufferStatus)(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw Error(ErrorKind::usage, "llvmpipe does not draw into this format");
  }

  /// Positions alone, or pairs of position and uv, each once.
  void upload_mesh() {
    const geometry::Mesh& mesh = scene_.mesh;
    std::map<std::pair<std::int32_t, std::int32_t>, std::uint32_t> place;
    std::vector<float> vertices;
    std::vector<std::uint32_t> indices;
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::pair corner{mesh.faces[face][k], finds_faces_ ? 0 : mesh.face_uvs[face][k]};
        const auto [entry, is_new] = place.emplace(corner, static_cast<std::uint32_t>(place.size()));
        indices.push_back(entry->second);
        if (!is_new) continue;
        for (const double v : mesh.positions[static_cast<std::size_t>(corner.first)])
          vertices.push_back(static_cast<float>(v));
        const auto& [u, v] = mesh.uvs[static_cast<std::size_t>(corner.second)];
        vertices.push_back(static_cast<float>(u / scene_.layout.u_extent));
        vertices.push_back(static_cast<float>(1 - v));  // the first row of texels has v = 1
      }
    }
    index_count_ = static_cast<GLsizei>(indices.size());
    std::array<GLuint, 3> names{};
    GL_CALL(glGenVertexArrays)(1, &names[0]);
    GL_CALL(glBindVertexArray)(names[0]);
    GL_CALL(glGenBuffers)(2, &names[1]);
    const auto fill = [&](GLenum point, GLuint name, const auto& values) {
      GL_CALL(glBindBuffer)(point, name);
      GL_CALL(glBufferData)(point, static_cast<GLsizeiptr>(4 * values.size()), values.data(), GL_STATIC_DRAW);
    };
    fill(GL_ARRAY_BUFFER, names[1], vertices);
    fill(GL_ELEMENT_ARRAY_BUFFER, names[2], indices);
    for (const GLuint attribute : {0U, 1U}) {
      GL_CALL(glVertexAttribPointer)
      (attribute, attribute == 0 ? 3 : 2, GL_FLOAT, GL_FALSE, 20,
       reinterpret_cast<const void*>(std::uintptr_t{12} * attribute));
      GL_CALL(glEnableVertexAttribArray)(attribute);
    }
  }

  void make_program() {
    const GLuint program = GL_CALL(glCreateProgram)();
    const auto attach = [&](GLenum kind, const char* text) {
      const GLuint shader = GL_CALL(glCreateShader)(kind);
      GL_CALL(glShaderSource)(shader, 1, &text, nullptr);
      GL_CALL(glCompileShader)(shader);
      GL_CALL(glAttachShader)(program, shader);
    };
    attach(GL_VERTEX_SHADER, vertex_program);
    attach(GL_FRAGMENT_SHADER, finds_faces_ ? face_program : paint_program);
    GL_CALL(glLinkProgram)(program);
    GLint is_linked = 0;
    GL_CALL(glGetProgramiv)(program, GL_LINK_STATUS, &is_linked);
    if (is_linked == 0) throw Error(ErrorKind::usage, "llvmpipe does not take the shaders");
    GL_CALL(glUseProgram)(program);
    matrix_ = GL_CALL(glGetUniformLocation)(program, "clip_from_world");
  }

  void upload_texture() {
    GLuint name = 0;
    GL_CALL(glGenTextures)(1, &name);
    GL_CALL(glBindTexture)(GL_TEXTURE_2D, name);
    GL_CALL(glTexImage2D)
    (GL_TEXTURE_2D, 0, GL_RGBA32F, static_cast<GLsizei>(scene_.layout.width),
     static_cast<GLsizei>(scene_.layout.height), 0, GL_RGB, GL_FLOAT, scene_.texels.data());
    for (const GLenum filter : {GLenum{GL_TEXTURE_MIN_FILTER}, GLenum{GL_TEXTURE_MAG_FILTER}})
      GL_CALL(glTexParameteri)(GL_TEXTURE_2D, filter, GL_LINEAR);
  }

  void draw(const geometry::Camera& camera) {
    static const auto clear_faces = GL_CALL(glClearBufferiv);
    static const auto clear_numbers = GL_CALL(glClearBufferfv);
    static const auto set_matrix = GL_CALL(glUniformMatrix4fv);
    static const auto draw_faces = GL_CALL(glDrawElements);
    static const auto finish = GL_CALL(glFinish);
    const std::array<GLint, 4> no_face{-1, -1, -1, -1};
    const std::array<GLfloat, 4> black{0, 0, 0, 0};
    const GLfloat farthest = 1;
    if (finds_faces_) {
      clear_faces(GL_COLOR, 0, no_face.data());
    } else {
      clear_numbers(GL_COLOR, 0, black.data());
    }
    clear_numbers(GL_DEPTH, 0, &farthest);
    set_matrix(matrix_, 1, GL_FALSE, clip_from_world(camera).data());
    draw_faces(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    finish();
  }

  const Scene& scene_;
  GLsizei size_;
  bool finds_faces_;
  OSMesaContext context_ = nullptr;
  std::vector<unsigned char> window_;
  GLsizei index_count_ = 0;
  GLint matrix_ = -1;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::LlvmpipeRenderer>(argc, argv, "ignored");
}
