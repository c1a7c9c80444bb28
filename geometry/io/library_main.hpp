#pragma once

// What the programs that run a library have in common, see library_process.hpp: limits on what they
// take, and what they made handed over through descriptor 3. Included by their main.cpp alone.

#include "geometry/base/sanitizers.hpp"
#include "geometry/io/assimp_messages.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>

#if defined(ASPIC_ADDRESS_SANITIZER)
extern "C" const char* __asan_default_options()
{
    return "hard_rss_limit_mb=4096:allocator_may_return_null=1:detect_leaks=0";
}
#elif defined(ASPIC_THREAD_SANITIZER)
extern "C" const char* __tsan_default_options()
{
    return "memory_limit_mb=4096";
}
#endif

namespace geometry {

#if defined(ASPIC_ADDRESS_SANITIZER) || defined(ASPIC_THREAD_SANITIZER)
// Sanitizers reserve terabytes: the limit is their own, on resident memory.
constexpr bool limits_address_space = false;
#else
constexpr bool limits_address_space = true;
#endif

inline void limit(__rlimit_resource what, double value)
{
    rlimit now{};
    getrlimit(what, &now);
    const double most = double(now.rlim_max == RLIM_INFINITY ? ~rlim_t{0} >> 1 : now.rlim_max);
    now.rlim_cur = static_cast<rlim_t>(std::clamp(value, 0.0, std::min(most, 9e18)));
    setrlimit(what, &now);
}

// Limits this process, and ends it with the one that started it.
inline void limit_process(double gigabytes, double seconds)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const double bytes = gigabytes * 0x1p30;
    if (limits_address_space) limit(RLIMIT_AS, bytes);
    limit(RLIMIT_FSIZE, bytes);
    limit(RLIMIT_CPU, std::ceil(seconds));
    limit(RLIMIT_CORE, 0);
}

inline bool write_all(int fd, const std::string& bytes)
{
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
        if (n <= 0) return false;
        done += static_cast<std::size_t>(n);
    }
    return true;
}

// What `job` made, packed; its error where it threw one.
template <class Made, class Job> std::string made_by(const Job& job)
{
    Made made;
    try {
        job(made);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        made.error = error.what();
    }
    return pack(made);
}

// Hands over what `job` returns and ends the process, without destructors that nobody waits for.
// Exit status: 0 something was made, or why it could not be; 3 memory ran out; anything else a
// crash.
template <class Job> [[noreturn]] void hand_over(const Job& job)
{
    try {
        if (!write_all(3, job())) {
            std::perror("handing over what was made");
            std::_Exit(1);
        }
    } catch (const std::bad_alloc&) {
        std::_Exit(3);
    }
    std::_Exit(0);
}

}  // namespace geometry
