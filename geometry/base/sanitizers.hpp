#pragma once

// Which sanitizer this is compiled with, by g++'s name for it or clang's: ASPIC_ADDRESS_SANITIZER,
// ASPIC_THREAD_SANITIZER, or neither.

#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define ASPIC_ADDRESS_SANITIZER
#elif __has_feature(thread_sanitizer)
#define ASPIC_THREAD_SANITIZER
#endif
#endif

#if defined(__SANITIZE_ADDRESS__)
#define ASPIC_ADDRESS_SANITIZER
#elif defined(__SANITIZE_THREAD__)
#define ASPIC_THREAD_SANITIZER
#endif
