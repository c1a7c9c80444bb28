// aspic-assimp: the process in which assimp runs, see geometry/io/library_process.hpp. What it made
// is packed by geometry/io/assimp_messages.hpp.

#include "geometry/io/assimp/jobs.hpp"
#include "geometry/io/library_main.hpp"

int main(int argc, char** argv)
{
    const std::vector<std::string> words(argv, argv + argc);
    if (argc != 6 || (words[1] != "read" && words[1] != "cameras" && words[1] != "write")) {
        std::fputs("aspic-assimp is run by aspic to read and write mesh files\n", stderr);
        return 2;
    }
    geometry::limit_process(std::atof(argv[4]), std::atof(argv[5]));

    using geometry::made_by;
    using geometry::assimp::read, geometry::assimp::write, geometry::assimp::Wanted;
    geometry::hand_over([&] {
        if (words[1] == "write") {
            return made_by<geometry::ExportedFiles>(
                [&](geometry::ExportedFiles& files) { write(0, words[2], words[3], files); });
        }
        const Wanted wanted = words[1] == "cameras" ? Wanted::cameras : Wanted::meshes;
        return made_by<geometry::ImportedScene>(
            [&](geometry::ImportedScene& scene) { read(words[2], words[3], wanted, scene); });
    });
}
