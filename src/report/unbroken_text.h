#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// Plain text as HTML in which "c₀ − c" and "μ = 0.3" stay on one line: words joined by = − ≈ ± × and short
/// fractions stand in
/// <span class="formula-text">. Everything is escaped; the text content is the text as it was.
std::string unbroken_formulae(std::string_view text);

/// Plain text as HTML that breaks at spaces only, never after a hyphen: for commands, which a reader copies. A word too
/// long for a line may still break anywhere.
std::string unbroken_words(std::string_view text);

}  // namespace granuscope
