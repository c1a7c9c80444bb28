#include "runtime/program_identity.hpp"

#include "runtime/file_digests.hpp"

#include <cstring>
#include <elf.h>
#include <link.h>

namespace runtime {

namespace {

struct Found {
    KeyBuilder ids;
    bool first = true, program = false;
};

// Notes are (name size, content size, type, name, content), each padded to 4 bytes.
int add_build_id(dl_phdr_info* object, std::size_t, void* user)
{
    Found& found = *static_cast<Found*>(user);
    const bool is_program = std::exchange(found.first, false);
    for (int i = 0; i < object->dlpi_phnum; ++i) {
        const ElfW(Phdr)& header = object->dlpi_phdr[i];
        if (header.p_type != PT_NOTE) continue;
        const char* note = reinterpret_cast<const char*>(object->dlpi_addr + header.p_vaddr);
        const char* const end = note + header.p_memsz;
        while (note + sizeof(ElfW(Nhdr)) <= end) {
            ElfW(Nhdr) n;
            std::memcpy(&n, note, sizeof n);
            const char* const name = note + sizeof n;
            const char* const content = name + (n.n_namesz + 3u) / 4 * 4;
            if (n.n_type == NT_GNU_BUILD_ID && n.n_namesz == 4 && !std::memcmp(name, "GNU", 4)) {
                found.ids.add(std::string_view(content, n.n_descsz));
                found.program = found.program || is_program;
            }
            note = content + (n.n_descsz + 3u) / 4 * 4;
        }
    }
    return 0;
}

}  // namespace

Key program_identity()
{
    Found found;
    dl_iterate_phdr(add_build_id, &found);
    // Linked without an id: the file's own bytes have to do.
    if (!found.program) found.ids.add(FileDigests().of("/proc/self/exe"));
    return found.ids.key();
}

}  // namespace runtime
