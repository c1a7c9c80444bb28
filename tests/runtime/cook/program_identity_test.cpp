#include "runtime/cook/program_identity.hpp"

#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>

using namespace runtime;

namespace {

Key identity_with(const std::filesystem::path& program)
{
    const std::vector programs{program};
    return program_identity({}, programs);
}

}  // namespace

TEST(ProgramIdentity, IsTheSameEachTime)
{
    EXPECT_EQ(program_identity(), program_identity());
    EXPECT_EQ(identity_with("/bin/sh"), identity_with("/bin/sh"));
}

TEST(ProgramIdentity, HasThatOfTheProgramsThatItRuns)
{
    const std::set<Key> all{program_identity(), identity_with("/bin/sh"), identity_with("/bin/ls")};
    EXPECT_EQ(all.size(), 3u);
}

TEST(ProgramIdentity, OfAProgramIsItsBuildAndNotItsPlace)
{
    const toys::Folder folder;
    std::filesystem::copy("/bin/ls", folder.path / "ls");
    EXPECT_EQ(identity_with(folder.path / "ls"), identity_with("/bin/ls"));
}

TEST(ProgramIdentity, OfAScriptIsItsBytes)
{
    const toys::Folder folder;
    const auto script = folder.write("assimp", "#!/bin/sh\nexec /opt/1/aspic-assimp\n");
    const Key before = identity_with(script);
    folder.write("assimp", "#!/bin/sh\nexec /opt/2/aspic-assimp\n");
    EXPECT_NE(identity_with(script), before);
}
