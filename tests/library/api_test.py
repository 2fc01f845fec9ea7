#!/usr/bin/env python3
"""What toolchain/library/api.py takes for a public declaration, and what makes a difference to it."""

import sys
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'toolchain/library'))
import api  # noqa: E402

HEADER = '''#pragma once
#include <vector>
#define LONG 1 \\
  + 2
namespace smaservo {
static_assert(sizeof(int) == 4, "; {");
/// A point; { of } a "path".
template <class S>
struct Point : Base<S> {
  S x, y;  ///< m
  S z = S(1), w{2};
  static constexpr auto text = R"toml(}; { )toml";
  Point(S a, S b) : x(a), y{b}, z(f({a})) { x += 1; }
  explicit Point(int) noexcept;
  bool operator==(const Point&) const = default;
  void operator()(int i = 3) const { { i; } }
  [[nodiscard]] S sum(std::map<int, S> by = {}) const {
    return x + y;
  }

 private:
  S hidden;
  struct Inner { int i; };

 public:
  friend Point operator&(Point&& a, Point* b) { return a; }
};
namespace detail {
int helper();
}
namespace {
int local = 1;
}
template <class S>
Point<S>::Point(int) noexcept {}
template <class S>
S Point<S>::other() { return {}; }
class Closed {
  int i;
};
enum class Kind : char {
  one,  ///< 1
  two = 5,
};
template <class T>
concept Good = requires(T t) {
  /// must be
  { t.f() } -> std::same_as<void>;
} && Other<T>;
template <class T>
  requires Good<T>
auto use(T&& t) -> decltype(t.f()) { return t.f(); }
using Name = std::pair<int, char>;
inline constexpr int bits = 1'000;
extern const char* names[3];
}  // namespace smaservo
'''

WANTED = '''namespace smaservo
  template <class S> struct Point : Base<S>
    S x, y
    S z = ..., w = ...
    static constexpr auto text = ...
    Point(S a, S b)
    explicit Point(int) noexcept
    bool operator==(const Point&) const = default
    void operator()(int i = 3) const
    [[nodiscard]] S sum(std::map<int, S> by = {}) const
    friend Point operator&(Point&& a, Point* b)
  class Closed
  enum class Kind : char { one, two = 5 }
  template <class T> concept Good = requires (T t) { { t.f() } -> std::same_as<void>; } && Other<T>
  template <class T> requires Good<T> auto use(T&& t) -> decltype(t.f())
  using Name = std::pair<int, char>
  inline constexpr int bits = ...
  extern const char* names[3]'''


class Api(unittest.TestCase):
    maxDiff = None

    def test_says_what_is_public(self):
        self.assertEqual('\n'.join(api.api_of(HEADER)), WANTED)

    def test_formatting_and_comments_make_no_difference(self):
        tokens = api.tokens_of(HEADER)
        self.assertEqual('\n'.join(api.api_of('\n'.join(tokens))), WANTED)
        self.assertEqual('\n'.join(api.api_of(' /* ; { */ '.join(tokens))), WANTED)

    def test_each_token_of_a_declaration_makes_a_difference(self):
        public = api.tokens_of('namespace a { int f(const B& b, int c = 1) noexcept; }')
        before = api.api_of(' '.join(public))
        for place, token in enumerate(public):
            if token.isidentifier() and token != 'namespace':
                changed = public[:place] + [token + 'x'] + public[place + 1:]
                self.assertNotEqual(api.api_of(' '.join(changed)), before, token)

    def test_what_it_does_not_understand_is_an_error(self):
        for text in ('namespace a { int f(; }', 'namespace a {', 'struct A { int i; }; }'):
            with self.assertRaises((ValueError, IndexError), msg=text):
                api.api_of(text)


unittest.main()
