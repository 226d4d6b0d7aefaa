#include "shared/tools/device_check/exported_symbols.hpp"

#include <elf.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

namespace stillgrid::device_check {
namespace {

/// The bytes of a file, of which nothing is believed.
class ElfFile {
 public:
  explicit ElfFile(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
    constexpr bool is_little = std::endian::native == std::endian::little;
    constexpr char kOrder = is_little ? ELFDATA2LSB : ELFDATA2MSB;
    if (!std::string_view(bytes_).starts_with(ELFMAG) || bytes_.size() < sizeof(Elf64_Ehdr) ||
        bytes_[EI_CLASS] != ELFCLASS64 || bytes_[EI_DATA] != kOrder)
      throw std::runtime_error("no 64-bit ELF library for this processor");
  }

  template <class Struct>
  [[nodiscard]] Struct at(std::uint64_t offset) const {
    Struct value;
    if (offset > bytes_.size() || bytes_.size() - offset < sizeof value) refuse();
    std::memcpy(&value, bytes_.data() + offset, sizeof value);
    return value;
  }

  [[nodiscard]] std::string text(std::uint64_t offset) const {
    const std::size_t end = offset < bytes_.size() ? bytes_.find('\0', offset) : std::string::npos;
    if (end == std::string::npos) refuse();
    return bytes_.substr(offset, end - offset);
  }

  [[nodiscard]] Elf64_Shdr section(const Elf64_Ehdr& header, std::uint64_t number) const {
    return at<Elf64_Shdr>(header.e_shoff + number * sizeof(Elf64_Shdr));
  }

 private:
  [[noreturn]] static void refuse() { throw std::runtime_error("an ELF file that is cut off"); }

  std::string bytes_;
};

bool is_exported(const Elf64_Sym& symbol) {
  const unsigned binding = ELF64_ST_BIND(symbol.st_info);
  const unsigned visibility = ELF64_ST_VISIBILITY(symbol.st_other);
  const bool is_global = binding == STB_GLOBAL || binding == STB_WEAK || binding == STB_GNU_UNIQUE;
  // SHN_ABS: the names of versions, and the linker's marks
  return is_global && symbol.st_shndx != SHN_UNDEF && symbol.st_shndx != SHN_ABS &&
         (visibility == STV_DEFAULT || visibility == STV_PROTECTED);
}

}  // namespace

std::vector<std::string> exported_symbols(const std::filesystem::path& library) {
  const ElfFile file(library);
  const auto header = file.at<Elf64_Ehdr>(0);
  std::vector<std::string> names;
  for (unsigned number = 0; number < header.e_shnum; ++number) {
    const Elf64_Shdr table = file.section(header, number);
    if (table.sh_type != SHT_DYNSYM) continue;
    const Elf64_Shdr strings = file.section(header, table.sh_link);
    for (std::uint64_t at = 0; at + sizeof(Elf64_Sym) <= table.sh_size; at += sizeof(Elf64_Sym)) {
      const auto symbol = file.at<Elf64_Sym>(table.sh_offset + at);
      if (is_exported(symbol)) names.push_back(file.text(strings.sh_offset + symbol.st_name));
    }
  }
  return names;
}

}  // namespace stillgrid::device_check
