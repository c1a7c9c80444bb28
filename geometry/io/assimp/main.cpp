// aspic-assimp: the process in which assimp runs, see geometry/io/assimp_process.hpp. What it made
// goes to descriptor 3, as geometry/io/assimp_messages.hpp packs it. Exit status: 0 something was
// made, or why it could not be; 3 memory ran out; anything else a crash.

#include "geometry/base/sanitizers.hpp"
#include "geometry/io/assimp/jobs.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

#if defined(ASPIC_ADDRESS_SANITIZER)
// The address sanitizer reserves terabytes: the limit is its own, on resident memory.
constexpr bool limits_address_space = false;
extern "C" const char* __asan_default_options()
{
    return "hard_rss_limit_mb=4096:allocator_may_return_null=1:detect_leaks=0";
}
#elif defined(ASPIC_THREAD_SANITIZER)
constexpr bool limits_address_space = false;
extern "C" const char* __tsan_default_options()
{
    return "memory_limit_mb=4096";
}
#else
constexpr bool limits_address_space = true;
#endif

void limit(__rlimit_resource what, double value)
{
    rlimit now{};
    getrlimit(what, &now);
    const double most = double(now.rlim_max == RLIM_INFINITY ? ~rlim_t{0} >> 1 : now.rlim_max);
    now.rlim_cur = static_cast<rlim_t>(std::clamp(value, 0.0, std::min(most, 9e18)));
    setrlimit(what, &now);
}

bool write_all(int fd, const std::string& bytes)
{
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
        if (n <= 0) return false;
        done += static_cast<std::size_t>(n);
    }
    return true;
}

// What `job` made, packed; its error where it threw one.
template <class Made, class Job> std::string done(const Job& job)
{
    Made made;
    try {
        job(made);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        made.error = error.what();
    }
    return geometry::pack(made);
}

}  // namespace

int main(int argc, char** argv)
{
    const std::vector<std::string> words(argv, argv + argc);
    if (argc != 6 || (words[1] != "read" && words[1] != "cameras" && words[1] != "write")) {
        std::fputs("aspic-assimp is run by aspic to read and write mesh files\n", stderr);
        return 2;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const double bytes = std::atof(argv[4]) * 0x1p30;
    if (limits_address_space) limit(RLIMIT_AS, bytes);
    limit(RLIMIT_FSIZE, bytes);
    limit(RLIMIT_CPU, std::ceil(std::atof(argv[5])));
    limit(RLIMIT_CORE, 0);

    using geometry::assimp::read, geometry::assimp::write, geometry::assimp::Wanted;
    try {
        const std::string made =
            words[1] != "write"
                ? done<geometry::ImportedScene>([&](geometry::ImportedScene& scene) {
                      read(words[2], words[3],
                           words[1] == "cameras" ? Wanted::cameras : Wanted::meshes, scene);
                  })
                : done<geometry::ExportedFiles>(
                      [&](geometry::ExportedFiles& files) { write(0, words[2], words[3], files); });
        if (!write_all(3, made)) {
            std::perror("handing over what was made");
            std::_Exit(1);
        }
    } catch (const std::bad_alloc&) {
        std::_Exit(3);
    }
    std::_Exit(0);
}
