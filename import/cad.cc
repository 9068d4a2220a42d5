/* SPDX-License-Identifier: MIT */
#include "cad.h"

#include "edges.h"
#include "face.h"
#include "import.h"
#include "kind.h"
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Msg.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeExtend_DataMapIteratorOfDataMapOfShapeListOfMsg.hxx>
#include <ShapeExtend_MsgRegistrator.hxx>
#include <ShapeFix_Shape.hxx>
#include <StepShape_EdgeLoop.hxx>
#include <StepShape_Face.hxx>
#include <StepShape_FaceBound.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <istream>
#include <map>
#include <streambuf>
#include <string_view>

namespace drape {
namespace {

constexpr double NUMBER_MAX = 1e12; /* of coordinates and weights; api/request/decode.h */

struct unit_name {
    const char *ours, *cascade, *words[3];
};
const unit_name units[] = {{"mm", "MM", {"millimetre", "millimeter", "mm"}},
                           {"m", "M", {"metre", "meter", "m"}},
                           {"in", "INCH", {"inch", "in", "INCH"}},
                           {"cm", "CM", {"centimetre", "centimeter", "cm"}},
                           {"ft", "FT", {"foot", "feet", "ft"}},
                           {"um", "UM", {"micrometre", "micrometer", "micron"}}};

const unit_name *find_unit(const std::string &word) {
    std::string lower = word;
    for (char &c : lower)
        c = char(std::tolower(static_cast<unsigned char>(c)));
    for (const unit_name &unit : units)
        for (const char *name : unit.words)
            if (lower == name)
                return &unit;
    return nullptr;
}

std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

/* Faults of faces by what they are. */
struct fault_group {
    std::vector<int> faces;
    double worst = 0;
};

/* Bytes in memory as a stream. */
struct memory_buffer : std::streambuf {
    memory_buffer(const char *bytes, size_t length) {
        char *start = const_cast<char *>(bytes);
        setg(start, start, start + length);
    }
    pos_type seekoff(off_type offset, std::ios_base::seekdir way,
                     std::ios_base::openmode) override {
        char *from = way == std::ios_base::beg   ? eback()
                     : way == std::ios_base::cur ? gptr()
                                                 : egptr();
        if (from + offset < eback() || from + offset > egptr())
            return pos_type(off_type(-1));
        setg(eback(), from + offset, egptr());
        return gptr() - eback();
    }
    pos_type seekpos(pos_type at, std::ios_base::openmode mode) override {
        return seekoff(off_type(at), std::ios_base::beg, mode);
    }
};

/* A name that somebody gave; "" for one that translators make up where there is none. */
std::string own_name(const std::string &name) {
    for (const char *start : {"Open CASCADE STEP translator", "=>["})
        if (name.compare(0, std::strlen(start), start) == 0)
            return "";
    for (const char *word : {"NONE", "COMPOUND", "SOLID", "SHELL", "FACE"})
        if (name == word)
            return "";
    return name;
}

/* ---- the file's entities ---- */

/* A CAD file while it is read. */
class reading {
  public:
    reading(const selection &chosen) : wanted(chosen) { result.notes = chosen.notes; }
    void read_step(const char *bytes, size_t length);
    void read_iges(const char *bytes, size_t length);
    part convert();

  private:
    const selection &wanted;
    part result;
    Handle(TDocStd_Document) document;
    std::map<const TopoDS_TShape *, std::string> entity_names; /* of faces, by their entities */
    std::map<const TopoDS_TShape *, std::vector<fault>>
        read_faults;                           /* of faces as they were read */
    std::map<std::string, int> healed;         /* of more than faces, by what was done, how often */
    std::vector<std::pair<int, fault>> faults; /* by their faces */
    std::vector<found_face> found;
    int bodies = 0, parts = 0; /* parts: instances that have faces */
    size_t edges = 0;          /* of no face */
    size_t lost = 0;           /* faces that nothing became of */
    std::string lost_first;
    const char *faceless = ""; /* what the file may hold beside faces, of a STEP file */
    std::string elsewhere;     /* the files that the parts of an assembly are in, by comma */

    void set_unit(const std::vector<std::string> &stated);
    void name_entities(const Handle(XSControl_WorkSession) & session);
    void collect(const Handle(XSControl_WorkSession) & session);
    [[noreturn]] void refuse_empty();
    void note_contents();
    void walk(const TDF_Label &label, const TopLoc_Location &place, const std::string &name);
    void add_shape(const TDF_Label &label, const TopLoc_Location &place, const std::string &name);
    Handle(ShapeBuild_ReShape) heal(const TopoDS_Shape &shape);
    std::string colour_of(const TopoDS_Shape &face, const TDF_Label &label);
    void note(const std::string &text) { result.notes.push_back(text); }
    void note_faults();
    void convert_face(int number, Bnd_Box &box);
    void measure(const found_face &from, face &made);
};

void reading::set_unit(const std::vector<std::string> &stated) {
    const unit_name *unit = nullptr;
    for (const std::string &word : stated) {
        const unit_name *here = find_unit(word);
        if (!here)
            note("the file's unit \"" + word + "\" is not known; lengths are taken as mm");
        else if (unit && here != unit)
            note("the file's bodies have different units; all lengths are in " +
                 std::string(unit->ours));
        else
            unit = here;
    }
    if (unit && !wanted.unit.empty() && wanted.unit != unit->ours)
        note("the file states its unit, " + std::string(unit->ours) + "; unit=" + wanted.unit +
             " was ignored");
    for (const unit_name &named : units)
        if (!unit && wanted.unit == named.ours)
            unit = &named;
    unit = unit ? unit : &units[0];
    result.unit = unit->ours;
    Interface_Static::SetCVal("xstep.cascade.unit", unit->cascade);
}

/* Whether an entity of an IGES file is meant to become a face. */
bool is_face_type(int type) {
    enum { BOUNDED = 143, TRIMMED = 144, FACE = 510 };
    return type == BOUNDED || type == TRIMMED || type == FACE;
}

/* "" without. */
std::string entity_name(const Handle(Standard_Transient) & entity) {
    Handle(StepShape_Face) face = Handle(StepShape_Face)::DownCast(entity);
    Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
    Handle(TCollection_HAsciiString) name;
    if (!face.IsNull())
        name = face->Name();
    else if (!iges.IsNull() && iges->HasName())
        name = iges->NameValue();
    if (name.IsNull())
        return "";
    name->LeftAdjust();
    name->RightAdjust();
    std::string text = name->ToCString();
    if (!iges.IsNull() && text.size() > 3 && text.compare(text.size() - 3, 3, "(0)") == 0)
        text.resize(text.size() - 3); /* no subscript of a label */
    return own_name(text);
}

/* How many edges the bounds of a face have in a STEP file. */
int bounding_edges(const StepShape_Face &face) {
    int count = 0;
    for (int i = 1; i <= face.NbBounds(); i++) {
        Handle(StepShape_FaceBound) bound = face.BoundsValue(i);
        Handle(StepShape_EdgeLoop) loop;
        if (!bound.IsNull())
            loop = Handle(StepShape_EdgeLoop)::DownCast(bound->Bound());
        count += loop.IsNull() ? 0 : loop->NbEdgeList();
    }
    return count;
}

/* Whether a face was cut where its bound crosses itself: what it became has more edges than the
 * file gives it, those between two pieces and seams aside, and four ends of them at one place. */
bool was_cut(const TopoDS_Shape &pieces, int edges_in_file) {
    enum { CROSSING = 4 };
    std::map<const TopoDS_TShape *, int> times, ends;
    int count = 0, most = 0;
    for (TopExp_Explorer at(pieces, TopAbs_EDGE); at.More(); at.Next())
        times[at.Current().TShape().get()]++;
    for (TopExp_Explorer at(pieces, TopAbs_EDGE); at.More(); at.Next()) {
        const TopoDS_Edge &edge = TopoDS::Edge(at.Current());
        if (BRep_Tool::Degenerated(edge) || times[edge.TShape().get()] > 1)
            continue;
        count++;
        for (const TopoDS_Vertex &end : {TopExp::FirstVertex(edge), TopExp::LastVertex(edge)})
            if (!end.IsNull())
                most = std::max(most, ++ends[end.TShape().get()]);
    }
    return count > edges_in_file && most >= CROSSING;
}

/* The names that the file gives to its faces themselves, those of which nothing became, and those
 * that were cut. */
void reading::name_entities(const Handle(XSControl_WorkSession) & session) {
    Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
    Handle(Interface_InterfaceModel) model = session->Model();
    for (int i = 1; i <= model->NbEntities(); i++) {
        Handle(Standard_Transient) entity = model->Value(i);
        TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
        std::string own = entity_name(entity);
        Handle(StepShape_Face) face = Handle(StepShape_Face)::DownCast(entity);
        Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
        bool meant = !face.IsNull() || (!iges.IsNull() && is_face_type(iges->TypeNumber()));
        if (shape.IsNull() && meant && lost++ == 0)
            lost_first = std::string(model->StringLabel(entity)->ToCString()) +
                         (own.empty() ? "" : " (\"" + own + "\")");
        if (shape.IsNull())
            continue;
        bool cut = !face.IsNull() && was_cut(shape, bounding_edges(*face));
        for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next()) {
            if (!own.empty())
                entity_names[at.Current().TShape().get()] = own;
            if (cut)
                read_faults[at.Current().TShape().get()] = {
                    {"a trim crosses itself, and the face was cut there"}};
        }
    }
}

void reading::read_step(const char *bytes, size_t length) {
    memory_buffer buffer(bytes, length);
    std::istream stream(&buffer);
    faceless = kind_of_faceless(bytes, length);
    STEPCAFControl_Reader reader;
    reader.SetColorMode(true);
    reader.SetNameMode(true);
    if (reader.ChangeReader().ReadStream("file", stream) != IFSelect_RetDone)
        throw unreadable("the file is damaged: it cannot be parsed as STEP");
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles);
    std::vector<std::string> stated;
    for (const TCollection_AsciiString &word : lengths)
        stated.push_back(word.ToCString());
    set_unit(stated);
    document = new TDocStd_Document("BinXCAF");
    if (!reader.Transfer(document))
        throw unreadable(std::string("the STEP file has no shape") + faceless);
    for (NCollection_DataMap<TCollection_AsciiString, Handle(STEPCAFControl_ExternFile)>::Iterator
             at(reader.ExternFiles());
         at.More(); at.Next())
        elsewhere += (elsewhere.empty() ? "" : ", ") + std::string(at.Key().ToCString());
    collect(reader.Reader().WS());
}

/* Open CASCADE reads IGES from standard input when the name is empty. */
void reading::read_iges(const char *bytes, size_t length) {
    FILE *memory = fmemopen(const_cast<char *>(bytes), length, "r");
    if (!memory)
        throw unreadable("there is no memory to read the file");
    stdin = memory;
    IGESCAFControl_Reader reader;
    reader.SetColorMode(true);
    reader.SetNameMode(true);
    if (reader.ReadFile("") != IFSelect_RetDone)
        throw unreadable("the file is damaged: it cannot be parsed as IGES");
    Handle(IGESData_IGESModel) model = reader.IGESModel();
    const IGESData_GlobalSection &global = model->GlobalSection();
    const char *const flags[] = {"",  "in", "mm",  "",   "ft", "mile",
                                 "m", "km", "mil", "um", "cm", "uin"};
    int flag = global.UnitFlag();
    std::vector<std::string> stated;
    if (flag > 0 && flag < 12 && flags[flag][0])
        stated.push_back(flags[flag]);
    else if (!global.UnitName().IsNull())
        stated.push_back(global.UnitName()->ToCString());
    set_unit(stated);
    document = new TDocStd_Document("BinXCAF");
    if (!reader.Transfer(document))
        throw unreadable("the IGES file has no shape");
    collect(reader.WS());
}

/* ---- shapes, parts and instances ---- */

/* Its own, else that of the shape it is of; "" without. */
std::string reading::colour_of(const TopoDS_Shape &face, const TDF_Label &label) {
    Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
    Quantity_Color colour;
    if (!colours->GetColor(face, XCAFDoc_ColorSurf, colour) &&
        !colours->GetColor(face, XCAFDoc_ColorGen, colour) &&
        !colours->GetColor(label, XCAFDoc_ColorSurf, colour) &&
        !colours->GetColor(label, XCAFDoc_ColorGen, colour))
        return "";
    char text[8];
    double r, g, b;
    colour.Values(r, g, b, Quantity_TOC_sRGB);
    std::snprintf(text, sizeof text, "#%02x%02x%02x", unsigned(std::lround(255 * r)) & 255,
                  unsigned(std::lround(255 * g)) & 255, unsigned(std::lround(255 * b)) & 255);
    return text;
}

/* Heals what the file's own translation left: what every shape has become. Open CASCADE tells what
 * it does to a face, to a wire of one, or to more. */
Handle(ShapeBuild_ReShape) reading::heal(const TopoDS_Shape &shape) {
    TopTools_IndexedDataMapOfShapeListOfShape of_wire;
    TopExp::MapShapesAndAncestors(shape, TopAbs_WIRE, TopAbs_FACE, of_wire);
    Handle(ShapeFix_Shape) fix = new ShapeFix_Shape(shape);
    Handle(ShapeExtend_MsgRegistrator) messages = new ShapeExtend_MsgRegistrator;
    fix->SetMsgRegistrator(messages);
    fix->Perform();
    for (ShapeExtend_DataMapIteratorOfDataMapOfShapeListOfMsg at(messages->MapShape()); at.More();
         at.Next())
        for (const Message_Msg &message : at.Value()) {
            Message_Msg copy(message);
            std::string what = TCollection_AsciiString(copy.Get()).ToCString();
            TopTools_ListOfShape faces;
            if (at.Key().ShapeType() == TopAbs_FACE)
                faces.Append(at.Key());
            else if (of_wire.Contains(at.Key()))
                faces = of_wire.FindFromKey(at.Key());
            for (const TopoDS_Shape &face : faces)
                read_faults[face.TShape().get()].push_back({"healed: " + what});
            healed[what] += faces.IsEmpty();
        }
    return fix->Context();
}

void reading::add_shape(const TDF_Label &label, const TopLoc_Location &place,
                        const std::string &name) {
    TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    if (shape.IsNull())
        return;
    Handle(ShapeBuild_ReShape) context = heal(shape);
    TopTools_IndexedMapOfShape in_solids, shells;
    for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) {
        TopExp::MapShapes(at.Current(), TopAbs_FACE, in_solids);
        bodies++;
    }
    for (TopExp_Explorer at(shape, TopAbs_EDGE, TopAbs_FACE); at.More(); at.Next())
        edges++;
    size_t before = found.size();
    TopTools_IndexedMapOfShape once;
    for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next()) {
        const TopoDS_Shape &face = at.Current();
        if (once.Contains(face))
            continue;
        once.Add(face);
        const std::string &own = entity_names[face.TShape().get()];
        for (TopExp_Explorer piece(context->Apply(face), TopAbs_FACE); piece.More(); piece.Next())
            found.push_back({TopoDS::Face(piece.Current().Moved(place)), own.empty() ? name : own,
                             colour_of(face, label), in_solids.Contains(face),
                             read_faults[face.TShape().get()]});
        if (found.size() > 1000000)
            throw unreadable("the file has more than 1000000 faces");
    }
    parts += found.size() > before;
}

/* An instance of an assembly has its place and its name, what it refers to has the shape. */
void reading::walk(const TDF_Label &label, const TopLoc_Location &place, const std::string &name) {
    TDF_Label referred = label;
    TopLoc_Location here = place;
    if (XCAFDoc_ShapeTool::IsReference(label)) {
        here = place * XCAFDoc_ShapeTool::GetLocation(label);
        XCAFDoc_ShapeTool::GetReferredShape(label, referred);
    }
    Handle(TDataStd_Name) attribute;
    std::string own;
    if (referred.FindAttribute(TDataStd_Name::GetID(), attribute))
        own = own_name(TCollection_AsciiString(attribute->Get(), '?').ToCString());
    if (!XCAFDoc_ShapeTool::IsAssembly(referred)) {
        add_shape(referred, here, own.empty() ? name : own);
        return;
    }
    TDF_LabelSequence components;
    XCAFDoc_ShapeTool::GetComponents(referred, components);
    for (const TDF_Label &component : components)
        walk(component, here, own);
}

/* Why the file has no face to drape. */
void reading::refuse_empty() {
    if (edges > 0)
        throw unreadable("the file holds only curves, " + count_text(edges, "edge") +
                         " and no face: export the surfaces or the solid");
    if (lost > 0)
        throw unreadable("none of the file's " + count_text(lost, "face") +
                         " can be read, the first is " + lost_first + ": export the file again");
    if (!elsewhere.empty())
        throw unreadable("the file is an assembly of parts in other files, and no other file is "
                         "read: send one of them, or export all as one file. They are " +
                         elsewhere);
    throw unreadable(std::string("the file holds no face") + faceless);
}

/* What was left out, what was healed, and what the faces are of. */
void reading::note_contents() {
    if (!elsewhere.empty())
        note("left out: the parts of the assembly that are in other files, " + elsewhere);
    if (lost > 0)
        note("left out: " + count_text(lost, "face") +
             " of the file that cannot be read, the first is " + lost_first);
    if (edges > 0)
        note("left out: " + count_text(edges, "edge") + " that no face has; only faces are draped");
    for (const auto &[what, times] : healed)
        if (times > 0)
            note("healed: " + what + (times > 1 ? " (" + std::to_string(times) + " times)" : ""));
    if (parts > 1)
        note(std::to_string(parts) +
             " bodies, each instance at its position: choose the faces to be draped");
    if (bodies > 0)
        note("a solid: its faces are both skins and the edges between them; choose the faces of "
             "the tool side, or one face and all that join it smoothly");
}

/* All faces of the document, and what the file says of those that are not there. */
void reading::collect(const Handle(XSControl_WorkSession) & session) {
    name_entities(session);
    TDF_LabelSequence roots;
    XCAFDoc_DocumentTool::ShapeTool(document->Main())->GetFreeShapes(roots);
    for (const TDF_Label &label : roots)
        walk(label, TopLoc_Location(), "");
    if (found.empty())
        refuse_empty();
    note_contents();
}

/* ---- faces ---- */

/* The mean of the outward normals over a grid of places, a unit vector; 0 when they cancel. */
gp_Vec mean_normal(const TopoDS_Face &face) {
    enum { STEPS = 11 };
    BRepAdaptor_Surface surface(face, true);
    BRepTopAdaptor_FClass2d inside(face, 1e-9);
    gp_Vec sum[2];
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            gp_Pnt at;
            gp_Vec u, v;
            double share[2] = {(i + 0.5) / STEPS, (j + 0.5) / STEPS};
            gp_Pnt2d uv(
                surface.FirstUParameter() * (1 - share[0]) + surface.LastUParameter() * share[0],
                surface.FirstVParameter() * (1 - share[1]) + surface.LastVParameter() * share[1]);
            surface.D1(uv.X(), uv.Y(), at, u, v);
            sum[0] += u.Crossed(v);
            if (inside.Perform(uv) == TopAbs_IN)
                sum[1] += u.Crossed(v);
        }
    gp_Vec mean = sum[1].Magnitude() > 0 ? sum[1] : sum[0];
    if (face.Orientation() == TopAbs_REVERSED)
        mean.Reverse();
    return mean.Magnitude() > 1e-9 * sum[0].Magnitude() && mean.Magnitude() > 0 ? mean.Normalized()
                                                                                : gp_Vec();
}

void reading::measure(const found_face &from, face &made) {
    GProp_GProps properties;
    Bnd_Box box;
    BRepGProp::SurfaceProperties(from.shape, properties, 1e-8);
    BRepBndLib::AddOptimal(from.shape, box, false, false);
    made.area = std::fabs(properties.Mass());
    if (!box.IsVoid())
        box.Get(made.box[0][0], made.box[0][1], made.box[0][2], made.box[1][0], made.box[1][1],
                made.box[1][2]);
    gp_Vec normal = mean_normal(from.shape);
    for (int k = 0; k < 3; k++) {
        made.centre[k] = properties.CentreOfMass().Coord(k + 1);
        made.normal[k] = normal.Coord(k + 1);
    }
}

/* A note for each kind of fault, with the first faces that have it. */
void reading::note_faults() {
    enum { NAMED = 8 };
    std::map<std::string, fault_group> groups;
    for (const auto &[number, one] : faults) {
        if (one.gap && one.by <= result.tolerance)
            continue;
        fault_group &group = groups[one.what];
        if (group.faces.empty() || group.faces.back() != number)
            group.faces.push_back(number);
        group.worst = std::max(group.worst, one.by);
    }
    for (const auto &[what, group] : groups) {
        size_t count = group.faces.size();
        std::string text =
            what +
            (group.worst > 0 ? ", by up to " + number_text(group.worst) + " " + result.unit : "") +
            ": ";
        if (count == 1)
            text += face_title(group.faces[0], found[size_t(group.faces[0])].name);
        for (size_t k = 0; count > 1 && k < std::min<size_t>(count, NAMED); k++)
            text += (k ? ", " : "faces ") + std::to_string(group.faces[k]);
        if (count > NAMED)
            text += " and " + std::to_string(count - NAMED) + " more";
        note(text);
    }
}

/* Damaged files have numbers that are none, and such as no part has. */
void check_numbers(const face &made) {
    auto check = [](const auto &values, double least) {
        for (double value : values)
            if (!(value >= least && value <= NUMBER_MAX))
                throw unreadable("has numbers that are too large or not finite");
    };
    for (const auto &point : made.points)
        check(point, -NUMBER_MAX);
    check(made.weights, 1 / NUMBER_MAX);
    for (const trim_loop &loop : made.loops)
        for (const trim_curve &curve : loop.curves) {
            for (const auto &point : curve.points)
                check(point, -NUMBER_MAX);
            check(curve.weights, 1 / NUMBER_MAX);
        }
}

/* Appends a face to the result, or a note why not. */
void reading::convert_face(int number, Bnd_Box &box) {
    const found_face &from = found[size_t(number)];
    std::vector<fault> wrong;
    GProp_GProps properties;
    try {
        face made = face_make(from.shape, wrong);
        check_numbers(made);
        made.name = from.name;
        made.colour = from.colour;
        BRepGProp::SurfaceProperties(from.shape, properties);
        if (!(std::fabs(properties.Mass()) > 0))
            throw unreadable("has no area");
        if (wanted.measured)
            measure(from, made);
        result.faces.push_back(made);
        result.numbers.push_back(number);
        BRepBndLib::Add(from.shape, box, false);
    } catch (const unreadable &why) {
        wrong.push_back({std::string("left out because it ") + why.what()});
    } catch (const Standard_Failure &failure) {
        wrong.push_back({std::string("left out because it cannot be converted (") +
                         failure.DynamicType()->Name() + ")"});
    }
    wrong.insert(wrong.begin(), from.faults.begin(), from.faults.end());
    for (const fault &one : wrong)
        faults.emplace_back(number, one);
}

void check_face_count(size_t count) {
    if (count > FACES_MAX)
        throw unreadable("the file has " + std::to_string(count) + " faces, but at most " +
                         std::to_string(FACES_MAX) +
                         " can be imported at once: export only those to be draped, or choose some "
                         "with drape-import --faces");
}

part reading::convert() {
    std::vector<int> numbers = wanted.faces;
    int count = int(found.size());
    for (int number : numbers)
        if (number < 0 || number >= count)
            throw unreadable("face " + std::to_string(number) +
                             " was asked for, but the file has " + std::to_string(count));
    for (int number = 0; wanted.faces.empty() && number < count; number++)
        numbers.push_back(number);
    check_face_count(numbers.size());
    Bnd_Box box;
    for (int number : numbers)
        convert_face(number, box);
    if (!result.faces.empty()) {
        double diagonal = std::sqrt(box.SquareExtent());
        result.edges = edges_count(found, result.numbers, diagonal, result.notes);
        result.tolerance = std::max(EDGES_TOLERANCE * diagonal, 2 * result.edges.largest_gap);
        if (result.tolerance > 0.1 * diagonal)
            throw unreadable("the file's tolerance, " + number_text(result.tolerance) +
                             ", is nearly as large as its faces");
    }
    note_faults();
    if (result.faces.empty())
        throw unreadable(result.notes.empty() ? "no face could be converted" : result.notes.back());
    return result;
}

/* How many faces a file describes, by their words alone: reading a hundred thousand takes minutes
 * and gigabytes. */
size_t step_faces(const char *bytes, size_t length) {
    static const std::string_view words[] = {"ADVANCED_FACE(", "FACE_SURFACE("};
    const std::string_view text(bytes, length);
    size_t count = 0;
    for (std::string_view word : words)
        for (size_t at = text.find(word, 1); at != text.npos; at = text.find(word, at + 1))
            count += text[at - 1] == '=' || text[at - 1] == ' ';
    return count;
}

/* The entries of an IGES directory have two lines; the first begins with the entity's number. */
size_t iges_faces(const char *bytes, size_t length) {
    enum { SECTION = 72, TYPE = 8 };
    const std::string_view text(bytes, length);
    size_t count = 0, lines = 0;
    for (size_t at = 0, end; at < length; at = end + 1) {
        end = std::min(text.find('\n', at), length);
        if (end - at <= SECTION || text[at + SECTION] != 'D' || lines++ % 2)
            continue;
        count += is_face_type(std::atoi(std::string(text.substr(at, TYPE)).c_str()));
    }
    return count;
}

} // namespace

part cad_read(cad_format format, const char *bytes, size_t length, const selection &wanted) {
    bool step = format == cad_format::step;
    if (length >= 3 && std::memcmp(bytes, "\xef\xbb\xbf", 3) == 0) { /* the mark of UTF-8 */
        bytes += 3;
        length -= 3;
    }
    if (kind_is_foreign(bytes, length) ||
        !(step ? kind_is_step(bytes, length) : kind_is_iges(bytes, length)))
        throw unreadable(kind_refusal(step ? "STEP" : "IGES", bytes, length));
    if (wanted.faces.empty())
        check_face_count(step ? step_faces(bytes, length) : iges_faces(bytes, length));
    try {
        reading reader(wanted);
        if (step)
            reader.read_step(bytes, length);
        else
            reader.read_iges(bytes, length);
        return reader.convert();
    } catch (const Standard_Failure &failure) {
        throw unreadable(std::string("the file cannot be read: ") + failure.DynamicType()->Name() +
                         " " + failure.GetMessageString());
    }
}

} // namespace drape

void import_prepare() {
    Message::DefaultMessenger()->ChangePrinters().Clear();
    STEPCAFControl_Reader step;
    IGESCAFControl_Reader iges;
    Handle(ShapeFix_Shape) fix = new ShapeFix_Shape;
}
