#include "runtime/cook/program_identity.hpp"

#include "runtime/cache/file_digests.hpp"

#include <cstring>
#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <set>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace runtime {

namespace {

struct Found {
    KeyBuilder ids;
    bool first = true, program = false;
};

// Calls see(id) for each build id among the notes.
// Notes are (name size, content size, type, name, content), each padded to 4 bytes.
template <class See> void each_build_id(const char* note, const char* end, const See& see)
{
    while (note + sizeof(ElfW(Nhdr)) <= end) {
        ElfW(Nhdr) n;
        std::memcpy(&n, note, sizeof n);
        const char* const name = note + sizeof n;
        const char* const content = name + (n.n_namesz + 3u) / 4 * 4;
        if (n.n_type == NT_GNU_BUILD_ID && n.n_namesz == 4 && !std::memcmp(name, "GNU", 4)) {
            see(std::string_view(content, n.n_descsz));
        }
        note = content + (n.n_descsz + 3u) / 4 * 4;
    }
}

int add_build_id(dl_phdr_info* object, std::size_t, void* user)
{
    Found& found = *static_cast<Found*>(user);
    const bool is_program = std::exchange(found.first, false);
    for (int i = 0; i < object->dlpi_phnum; ++i) {
        const ElfW(Phdr)& header = object->dlpi_phdr[i];
        if (header.p_type != PT_NOTE) continue;
        const char* note = reinterpret_cast<const char*>(object->dlpi_addr + header.p_vaddr);
        each_build_id(note, note + header.p_memsz, [&](std::string_view id) {
            found.ids.add(id);
            found.program = found.program || is_program;
        });
    }
    return 0;
}

// A file seen as memory; empty when it can't be.
class Mapped {
public:
    explicit Mapped(const std::string& path)
    {
        const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
        struct stat status {};
        if (file >= 0 && ::fstat(file, &status) == 0 && status.st_size > 0) {
            void* const at = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ,
                                    MAP_PRIVATE, file, 0);
            if (at != MAP_FAILED) {
                bytes_ = {static_cast<const char*>(at), static_cast<std::size_t>(status.st_size)};
            }
        }
        if (file >= 0) ::close(file);
    }
    ~Mapped()
    {
        if (!bytes_.empty()) ::munmap(const_cast<char*>(bytes_.data()), bytes_.size());
    }
    Mapped(const Mapped&) = delete;

    // What of the range lies in the file.
    std::string_view part(std::uint64_t at, std::uint64_t size) const
    {
        return at < bytes_.size() ? bytes_.substr(at, size) : std::string_view();
    }
    template <class T> T read(std::uint64_t at) const
    {
        T value{};
        const std::string_view from = part(at, sizeof value);
        if (from.size() == sizeof value) std::memcpy(&value, from.data(), sizeof value);
        return value;
    }

private:
    std::string_view bytes_;
};

// Where the loader would look for libraries, in its order.
std::vector<std::string> library_folders()
{
    std::vector<std::string> folders;
    void* const self = ::dlopen(nullptr, RTLD_LAZY);
    Dl_serinfo size{};
    if (!self || ::dlinfo(self, RTLD_DI_SERINFOSIZE, &size) != 0) return folders;
    std::vector<std::max_align_t> room(size.dls_size / sizeof(std::max_align_t) + 1);
    auto* const all = reinterpret_cast<Dl_serinfo*>(room.data());
    *all = size;
    if (::dlinfo(self, RTLD_DI_SERINFO, all) != 0) return folders;
    for (unsigned i = 0; i < all->dls_cnt; ++i) folders.emplace_back(all->dls_serpath[i].dls_name);
    return folders;
}

// Adds the build ids of programs and libraries that are not loaded and of what they need in turn,
// as their files say: program headers -> notes, and the dynamic section with the names of what they
// need.
class FilesAhead {
public:
    explicit FilesAhead(KeyBuilder& ids) : ids_(ids) {}

    void add_library(const std::string& name)
    {
        if (!seen_.insert(name).second) return;
        for (const std::string& folder : folders_) {
            if (add_object(folder + "/" + name)) return;
        }
        ids_.add("not found").add(name);
    }

    void add_program(const std::filesystem::path& path)
    {
        // A script that starts another program counts by its bytes.
        if (!add_object(path)) ids_.add(FileDigests().of(path));
    }

private:
    // False where it is none, or not there.
    bool add_object(const std::string& path)
    {
        const Mapped file(path);
        const auto header = file.read<ElfW(Ehdr)>(0);
        if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return false;
        std::vector<ElfW(Phdr)> parts;
        for (unsigned i = 0; i < header.e_phnum; ++i) {
            parts.push_back(file.read<ElfW(Phdr)>(header.e_phoff + i * sizeof(ElfW(Phdr))));
        }
        bool named = false;
        for (const ElfW(Phdr) & part : parts) {
            if (part.p_type != PT_NOTE) continue;
            const std::string_view notes = file.part(part.p_offset, part.p_filesz);
            each_build_id(notes.data(), notes.data() + notes.size(), [&](std::string_view id) {
                ids_.add(id);
                named = true;
            });
        }
        if (!named) ids_.add(FileDigests().of(path));
        for (const std::string& library : needed(file, parts)) add_library(library);
        return true;
    }

    static std::vector<std::string> needed(const Mapped& file, const std::vector<ElfW(Phdr)>& parts)
    {
        std::vector<std::uint64_t> offsets;  // into the names
        std::uint64_t names = 0;             // address
        for (const ElfW(Phdr) & part : parts) {
            if (part.p_type != PT_DYNAMIC) continue;
            for (std::uint64_t at = 0; at < part.p_filesz; at += sizeof(ElfW(Dyn))) {
                const auto entry = file.read<ElfW(Dyn)>(part.p_offset + at);
                if (entry.d_tag == DT_NULL) break;
                if (entry.d_tag == DT_NEEDED) offsets.push_back(entry.d_un.d_val);
                if (entry.d_tag == DT_STRTAB) names = entry.d_un.d_ptr;
            }
        }
        std::vector<std::string> all;
        for (const ElfW(Phdr) & part : parts) {
            const bool here = part.p_type == PT_LOAD && names >= part.p_vaddr &&
                              names < part.p_vaddr + part.p_filesz;
            for (std::size_t i = 0; here && i < offsets.size(); ++i) {
                const std::string_view name =
                    file.part(names - part.p_vaddr + part.p_offset + offsets[i], 256);
                all.emplace_back(name.substr(0, name.find('\0')));
            }
        }
        return all;
    }

    KeyBuilder& ids_;
    const std::vector<std::string> folders_ = library_folders();
    std::set<std::string> seen_;
};

}  // namespace

Key program_identity(std::span<const char* const> later,
                     std::span<const std::filesystem::path> programs)
{
    Found found;
    dl_iterate_phdr(add_build_id, &found);
    // Linked without an id: the file's own bytes have to do.
    if (!found.program) found.ids.add(FileDigests().of("/proc/self/exe"));
    FilesAhead ahead(found.ids);
    for (const char* const library : later) ahead.add_library(library);
    for (const std::filesystem::path& program : programs) ahead.add_program(program);
    return found.ids.key();
}

}  // namespace runtime
