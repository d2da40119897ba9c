// One line of JSON, built field by field.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <type_traits>
#include <vector>

namespace shrinkwrap::benchmarking {

class JsonLine {
 public:
  JsonLine& add(const std::string& key, const std::string& value) {
    return add_raw(key, quoted(value));
  }
  JsonLine& add(const std::string& key, const char* value) { return add_raw(key, quoted(value)); }
  JsonLine& add(const std::string& key, bool value) {
    return add_raw(key, value ? "true" : "false");
  }
  template <class Number, class = std::enable_if_t<std::is_arithmetic_v<Number>>>
  JsonLine& add(const std::string& key, Number value) {
    if constexpr (std::is_floating_point_v<Number>) {
      char text[32];
      std::snprintf(text, sizeof text, "%.7g", static_cast<double>(value));
      return add_raw(key, std::isfinite(value) ? text : "null");
    } else {
      return add_raw(key, std::to_string(value));
    }
  }
  JsonLine& add(const std::string& key, const JsonLine& value) {
    return add_raw(key, value.text());
  }
  JsonLine& add(const std::string& key, const std::vector<JsonLine>& values) {
    std::string list;
    for (const JsonLine& value : values) list += (list.empty() ? "" : ", ") + value.text();
    return add_raw(key, "[" + list + "]");
  }
  JsonLine& add(const std::string& key, const std::vector<std::string>& values) {
    std::string list;
    for (const std::string& value : values) list += (list.empty() ? "" : ", ") + quoted(value);
    return add_raw(key, "[" + list + "]");
  }
  std::string text() const { return "{" + fields_ + "}"; }

 private:
  static std::string quoted(const std::string& value) {
    std::string text = "\"";
    for (const char c : value) {
      if (c == '"' || c == '\\') text += '\\';
      text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return text + "\"";
  }
  JsonLine& add_raw(const std::string& key, const std::string& value) {
    fields_ += (fields_.empty() ? "" : ", ") + quoted(key) + ": " + value;
    return *this;
  }

  std::string fields_;
};

}  // namespace shrinkwrap::benchmarking
