#include "hal/table/xml.hpp"

#include <exception>
#include <expat.h>
#include <fmt/format.h>
#include <type_traits>

#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

using Parser = std::unique_ptr<std::remove_pointer_t<XML_Parser>, void (*)(XML_Parser)>;

std::string_view without_prefix(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// An exception must not pass through expat's frames, which are C.
struct Hearing {
  XML_Parser parser;
  XmlHandler& handler;
  std::exception_ptr thrown;

  template <class Call>
  void operator()(const Call& call) {
    if (thrown) {
      return;
    }
    try {
      call();
    } catch (...) {
      thrown = std::current_exception();
      XML_StopParser(parser, XML_FALSE);
    }
  }
};

Hearing& hearing(void* data) {
  return *static_cast<Hearing*>(data);
}

void on_begin(void* data, const char* name, const char** attributes) {
  Hearing& to = hearing(data);
  to([&] { to.handler.begin(without_prefix(name), XmlAttributes(attributes)); });
}

void on_end(void* data, const char* name) {
  Hearing& to = hearing(data);
  to([&] { to.handler.end(without_prefix(name)); });
}

void on_text(void* data, const char* text, int size) {
  Hearing& to = hearing(data);
  to([&] { to.handler.text({text, static_cast<std::size_t>(size)}); });
}

void on_document_type(void* data, const char* /*name*/, const char* /*system*/,
                      const char* /*public_id*/, int /*internal*/) {
  hearing(data)([] {
    throw files::UserError("declares a document type (DOCTYPE), which is refused; save it as CSV");
  });
}

}  // namespace

std::string_view XmlAttributes::operator[](std::string_view name) const {
  for (const char* const* at = all_; *at != nullptr; at += 2) {
    if (without_prefix(at[0]) == name) {
      return at[1];
    }
  }
  return {};
}

void read_xml(const ZipArchive& archive, const std::string& name, XmlHandler& handler) {
  const Parser parser(XML_ParserCreate(nullptr), XML_ParserFree);
  if (!parser) {
    throw files::UserError("no memory");
  }
  Hearing to{parser.get(), handler, nullptr};
  XML_SetUserData(parser.get(), &to);
  XML_SetElementHandler(parser.get(), on_begin, on_end);
  XML_SetCharacterDataHandler(parser.get(), on_text);
  XML_SetStartDoctypeDeclHandler(parser.get(), on_document_type);
  const auto parse = [&](std::string_view part, bool last) {
    const auto result = XML_Parse(parser.get(), part.data(), static_cast<int>(part.size()),
                                  last ? XML_TRUE : XML_FALSE);
    if (to.thrown) {
      std::rethrow_exception(to.thrown);
    }
    if (result != XML_STATUS_OK) {
      throw files::UserError(fmt::format("{} in the zip archive is damaged: line {}: {}", name,
                                         XML_GetCurrentLineNumber(parser.get()),
                                         XML_ErrorString(XML_GetErrorCode(parser.get()))));
    }
  };
  archive.read(name, [&](std::string_view part) { parse(part, false); });
  parse("", true);
}

}  // namespace smaservo::hal
